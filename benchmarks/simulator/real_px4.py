"""Real PX4 SITL as a benchmark's flight controller: started here, flown in lockstep, commanded by MAVLink."""

from __future__ import annotations

import math
import select
import socket
import time
from pathlib import Path
from typing import Callable, Mapping, Sequence

import numpy as np
from pymavlink.dialects.v20 import common

from benchmarks.simulator.px4_process import end_px4, start_px4
from simulation_tools.autopilot import VehicleState
from simulation_tools.px4.modes import Mode, Result
from simulation_tools.px4.setpoint import Setpoint
from simulation_tools.px4_sitl.hil_sensors import HilParameters
from simulation_tools.px4_sitl.px4_sitl import Px4Sitl
from simulation_tools.px4_sitl.simulator_link import DEFAULT_PORT, SimulatorLink

_HERE = "127.0.0.1"
_OUR_PORT, _PX4_PORT = 14540, 14580  # plus the instance
_START_S, _ANSWER_S = 60.0, 1.0  # wall time
_VALID_US = 500_000  # LOCAL_POSITION_NED comes 30 times a second
_NO_YAW, _NO_YAW_RATE, _NO_ACCELERATION = 1 << 10, 1 << 11, 0b111 << 6
_NO_VELOCITY, _NO_POSITION = 0b111 << 3, 0b111


class RealPx4:
    """An `Autopilot`, and what a `Pilot` commands. PX4's answers come in later steps; a refusal raises.

    messages: what arrives at PX4 at a state. PX4 has read each message before time goes on, so a flight does
    not depend on the machine's load.
    """

    def __init__(
        self,
        build: Path,
        instance: int,
        folder: Path,
        parameters: Mapping[str, float],
        seed: int,
        messages: Callable[[VehicleState], Sequence[common.MAVLink_message]],
        gnss: bool = False,
    ) -> None:
        """build: PX4's build/px4_sitl_default. folder: an empty one, where PX4 keeps its files.

        gnss: whether PX4 gets GPS.
        """
        rng = np.random.default_rng([seed, DEFAULT_PORT])
        self._sitl = Px4Sitl(SimulatorLink(DEFAULT_PORT + instance), HilParameters(gnss=gnss), rng, _START_S)
        self._instance, self._messages = instance, messages
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((_HERE, _OUR_PORT + instance))
        self._mav, self._parser = common.MAVLink(None, srcSystem=255), common.MAVLink(None)
        self._parser.robust_parsing = True
        self._up = False
        self._synced = 0
        self._time_us, self._valid_us = 0, -_VALID_US
        self._process = start_px4(build, instance, folder, parameters)

    # An Autopilot

    def is_ready(self) -> bool:
        """Whether PX4 has connected."""
        return self._sitl.is_ready()

    def begin(self, state: VehicleState) -> None:
        """Send a state's measurements to PX4."""
        self._sitl.begin(state)

    def step(self, state: VehicleState) -> np.ndarray:
        """Return the rotor commands (4,), and send PX4 what arrives at this state."""
        commands = self._sitl.step(state)
        self._time_us = state.time_us
        for message in self._messages(state):
            self._send(message)
        self._hear(0.0)
        return commands

    def reset(self) -> None:
        """Close the link to this PX4."""
        self._sitl.reset()

    def close(self) -> None:
        """End PX4 and close the ports."""
        self._sitl.close()
        self._socket.close()
        end_px4(self._process)

    # What a pilot needs

    @property
    def pid(self) -> int:
        """PX4's process id."""
        return self._process.pid

    @property
    def estimate_valid(self) -> bool:
        """Whether there is a local position."""
        return self._time_us - self._valid_us < _VALID_US

    def offer_setpoint(self, setpoint: Setpoint) -> bool:
        """Send an offboard setpoint of position or velocity, and heading or its rate."""
        position, velocity = setpoint.position, setpoint.velocity
        ignored = _NO_ACCELERATION
        ignored |= _NO_POSITION if np.isnan(position).any() else 0
        ignored |= _NO_VELOCITY if np.isnan(velocity).any() else 0
        ignored |= _NO_YAW if math.isnan(setpoint.yaw) else 0
        ignored |= _NO_YAW_RATE if math.isnan(setpoint.yaw_rate) else 0
        frame = common.MAV_FRAME_LOCAL_NED
        where = np.nan_to_num([*position, *velocity]).tolist()
        yaw = np.nan_to_num([setpoint.yaw, setpoint.yaw_rate]).tolist()
        self._send(
            common.MAVLink_set_position_target_local_ned_message(
                self._time_us // 1000, 1 + self._instance, 1, frame, ignored, *where, 0, 0, 0, *yaw
            )
        )
        return True

    def request_mode(self, mode: Mode) -> Result:
        """Ask for a mode."""
        self._command(common.MAV_CMD_DO_SET_MODE, 1, *mode.value)
        return Result.ACCEPTED

    def request_arm(self) -> Result:
        """Ask for arming."""
        self._command(common.MAV_CMD_COMPONENT_ARM_DISARM, 1)
        return Result.ACCEPTED

    def _command(self, command: int, *values: float) -> None:
        padded = (*values, *(0.0,) * (7 - len(values)))
        self._send(common.MAVLink_command_long_message(1 + self._instance, 1, command, 0, *padded))

    def _send(self, message: common.MAVLink_message) -> None:
        """Send a message. Once PX4 talks, wait until it has read it: it answers a TIMESYNC that follows."""
        self._write(message)
        if not self._up:
            return
        stamp = time.monotonic_ns()
        self._write(common.MAVLink_timesync_message(0, stamp))
        end_s = time.monotonic() + _ANSWER_S
        while self._synced != stamp and time.monotonic() < end_s:
            self._hear(0.1)

    def _write(self, message: common.MAVLink_message) -> None:
        self._socket.sendto(message.pack(self._mav), (_HERE, _PX4_PORT + self._instance))
        self._mav.seq = (self._mav.seq + 1) % 256

    def _hear(self, wait_s: float) -> None:
        """Read what has arrived; wait at most this long for it."""
        while select.select([self._socket], [], [], wait_s)[0]:
            wait_s = 0.0
            for message in self._parser.parse_buffer(self._socket.recv(65536)) or []:
                self._up = True
                self._heed(message)

    def _heed(self, message: common.MAVLink_message) -> None:
        kind = message.get_type()
        if kind == "TIMESYNC" and message.tc1 != 0:
            self._synced = message.ts1
        elif kind == "LOCAL_POSITION_NED" and math.isfinite(message.x):
            self._valid_us = self._time_us
        elif kind == "COMMAND_ACK" and message.result != common.MAV_RESULT_ACCEPTED:
            raise RuntimeError(f"PX4 refused command {message.command} with result {message.result}.")
