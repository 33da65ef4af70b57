"""Real ArduPilot SITL as a benchmark's flight controller, in lockstep, commanded by MAVLink."""

from __future__ import annotations

import math
from typing import Callable, Mapping, Sequence

import numpy as np
from pymavlink.dialects.v20 import common

from benchmarks.simulator.reference_quad import PACKAGE
from benchmarks.simulator.step_response import Pilot
from simulation_tools.ardupilot_sitl.ardupilot_sitl import ArduPilotSitl
from simulation_tools.ardupilot_sitl.json_link import JsonLink
from simulation_tools.ardupilot_sitl.json_sensors import JsonSensorParameters, JsonSensors
from simulation_tools.ardupilot_sitl.program import Program, ProgramParameters
from simulation_tools.autopilot import AutopilotError, VehicleState
from simulation_tools.geodesy import GeodeticOrigin
from simulation_tools.mavlink import Address, open_udp, receive_all, send
from simulation_tools.mavros.stacks import CopterStack
from simulation_tools.px4.modes import Mode, Result
from simulation_tools.px4.setpoint import Setpoint

_START_S = 60.0  # wall time
_LAST_S = 5.0  # for the rest of the climb
_ASK_US = 1_000_000  # from one try to arm to the next
_GUIDED = CopterStack().custom_mode("GUIDED") or 0
_NO_YAW, _NO_YAW_RATE, _NO_ACCELERATION = 1 << 10, 1 << 11, 0b111 << 6
_NO_VELOCITY, _NO_POSITION = 0b111 << 3, 0b111


class RealArduPilot:
    """An `Autopilot`, and what a `Pilot` commands.

    messages: what arrives at ArduPilot at a state. It stands in ArduPilot's socket before time goes on.
    """

    def __init__(
        self,
        path: str,
        seed: int,
        gnss: bool,
        settings: Mapping[str, float],
        messages: Callable[[VehicleState], Sequence[common.MAVLink_message]],
    ) -> None:
        """path: of arducopter. settings: parameters beside those of config/ardupilot*.parm."""
        self._gnss, self._messages = gnss, messages
        self._socket = open_udp("127.0.0.1", 0, "ArduPilot")
        self._ground = open_udp("127.0.0.1", 0, "ArduPilot's ground station")
        ports = [udp.getsockname()[1] for udp in (self._socket, self._ground)]
        names = ["ardupilot.parm"] + ([] if gnss else ["ardupilot_without_gnss.parm"])
        files = tuple(str(PACKAGE / "config" / name) for name in names)
        link = JsonLink(port=0)
        given = ProgramParameters(path, files, settings, offboard_port=ports[0], gcs_port=ports[1])
        sensors = JsonSensors(JsonSensorParameters(), np.random.default_rng([seed, 9002]))
        self._sitl = ArduPilotSitl(link, sensors, Program(given, link.port), _START_S)
        self._mav, self._parser = common.MAVLink(None, srcSystem=255), common.MAVLink(None)
        self._parser.robust_parsing = True
        self._peer: Address | None = None
        self._time_us, self._asked_us = 0, -_ASK_US
        self._is_booted = self.is_armed = False
        self.mode = -1
        self.said: list[str] = []
        """ArduPilot's texts so far."""

    # An Autopilot

    def is_ready(self) -> bool:
        """Whether ArduPilot asks for frames."""
        return self._sitl.is_ready()

    def begin(self, state: VehicleState) -> None:
        """Answer ArduPilot's first frame of a step."""
        self._sitl.begin(state)

    def step(self, state: VehicleState) -> np.ndarray:
        """Return the rotor commands (4,), and send ArduPilot what arrives at this state."""
        commands = self._sitl.step(state)
        self._time_us = state.time_us
        self._hear()
        for message in self._messages(state):
            self._send(message)
        return commands

    def reset(self) -> None:
        """Start ArduPilot again."""
        self._sitl.reset()

    def close(self) -> None:
        """End ArduPilot and close the ports."""
        self._sitl.close()
        self._socket.close()
        self._ground.close()

    # What a pilot needs

    @property
    def estimate_valid(self) -> bool:
        """Whether it is armed: it arms only with a local position."""
        return self.is_armed

    def offer_setpoint(self, setpoint: Setpoint) -> bool:
        """Send a setpoint of position or velocity, and heading or its rate."""
        ignored = _NO_ACCELERATION
        ignored |= _NO_POSITION if np.isnan(setpoint.position).any() else 0
        ignored |= _NO_VELOCITY if np.isnan(setpoint.velocity).any() else 0
        ignored |= _NO_YAW if math.isnan(setpoint.yaw) else 0
        ignored |= _NO_YAW_RATE if math.isnan(setpoint.yaw_rate) else 0
        where = np.nan_to_num([*setpoint.position, *setpoint.velocity]).tolist()
        yaw = np.nan_to_num([setpoint.yaw, setpoint.yaw_rate]).tolist()
        frame = common.MAV_FRAME_LOCAL_NED
        self._send(
            common.MAVLink_set_position_target_local_ned_message(
                self._time_us // 1000, 1, 1, frame, ignored, *where, 0, 0, 0, *yaw
            )
        )
        return True

    def request_mode(self, mode: Mode) -> Result:
        """Nothing: `take_off` has asked for GUIDED."""
        return Result.ACCEPTED

    def request_arm(self) -> Result:
        """Nothing: `take_off` has armed."""
        return Result.ACCEPTED

    def take_off(self, rise_m: float, pilot: Pilot, seconds: float) -> None:
        """Arm in GUIDED and rise, each in a time at most; AutopilotError tells what ArduPilot said."""
        pilot.fly(seconds, until=self._arms)
        if not self.is_armed:
            raise AutopilotError(f"ArduPilot did not arm within {seconds:g} s: {self.said[-3:]}")
        height_m = pilot.state.pose.position_m[2] + 0.9 * rise_m
        self._command(common.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, rise_m)
        pilot.fly(seconds, until=lambda: pilot.state.pose.position_m[2] > height_m)
        if pilot.state.pose.position_m[2] <= height_m:
            raise AutopilotError(f"ArduPilot did not take off within {seconds:g} s: {self.said[-3:]}")
        pilot.fly(_LAST_S)

    def _arms(self) -> bool:
        """Ask for arming now and then, and return whether it is armed."""
        # Before it is ready, a command would end it with a segmentation fault.
        if self._is_booted and self._time_us - self._asked_us >= _ASK_US:
            self._asked_us = self._time_us
            self._ask_to_arm()
        return self.is_armed

    def _ask_to_arm(self) -> None:
        if not self._gnss:
            place = GeodeticOrigin()
            degrees = round(1e7 * place.latitude_deg), round(1e7 * place.longitude_deg)
            self._send(
                common.MAVLink_set_gps_global_origin_message(1, *degrees, round(1e3 * place.altitude_m))
            )
        self._command(common.MAV_CMD_DO_SET_MODE, 1, _GUIDED)
        self._command(common.MAV_CMD_COMPONENT_ARM_DISARM, 1)

    def _command(self, command: int, *values: float) -> None:
        padded = (*values, *(0.0,) * (7 - len(values)))
        self._send(common.MAVLink_command_long_message(1, 1, command, 0, *padded))

    def _send(self, message: common.MAVLink_message) -> None:
        if self._peer is not None:
            send(self._socket, message.pack(self._mav), self._peer)
            self._mav.seq = (self._mav.seq + 1) % 256

    def _hear(self) -> None:
        for datagram, address in receive_all(self._socket):
            self._peer = address
            for message in self._parser.parse_buffer(datagram) or []:
                self._heed(message)
        for _ in receive_all(self._ground):
            pass

    def _heed(self, message: common.MAVLink_message) -> None:
        kind = message.get_type()
        if kind == "HEARTBEAT":
            self.is_armed = bool(message.base_mode & common.MAV_MODE_FLAG_SAFETY_ARMED)
            self._is_booted = message.system_status >= common.MAV_STATE_STANDBY
            self.mode = message.custom_mode
        elif kind == "STATUSTEXT":
            self.said.append(message.text)
