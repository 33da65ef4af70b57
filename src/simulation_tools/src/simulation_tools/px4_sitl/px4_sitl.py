"""Real PX4 as the simulator's flight controller, in lockstep with the physics."""

from __future__ import annotations

import math
import time
from typing import Callable

import numpy as np
from pymavlink.dialects.v20 import common

from simulation_tools.autopilot import Px4Error, VehicleState
from simulation_tools.px4_sitl.hil_sensors import HilParameters, HilSensors
from simulation_tools.px4_sitl.simulator_link import SimulatorLink, how_to_start

ROTORS = 4
_REAL_PACE_S = 0.004  # wall time; PX4 is still starting before its first answer
_PATIENCE_S = 0.5
_REMINDER_S = 10.0  # wall time


class Px4Sitl:
    """An `Autopilot` whose commands come from the PX4 at the other end of a link.

    `begin` sends HIL_SENSOR as soon as an instant is known. Then the simulator reads and publishes its other
    sensors. `step` waits for the HIL_ACTUATOR_CONTROLS that answers. Without PX4 the rotors stand still and
    the world goes on. If PX4 stops answering (for example at a debugger's breakpoint), simulated time nearly
    stops: each time-out advances it by one step with the last commands.

    PX4's clock begins with the first measurement and follows the messages' stamps. So simulated time waits
    at 0 for PX4, and both clocks agree. The clock of a second PX4, which connects after the first has ended,
    lags behind. PX4's clock must never go back, and PX4 cannot be rebooted over this link. So a reset of the
    simulation closes the link, and the user starts PX4 again.

    patience_s: wall time after which a missing PX4 is an error.
    """

    def __init__(
        self,
        link: SimulatorLink,
        parameters: HilParameters,
        rng: np.random.Generator,
        patience_s: float = math.inf,
    ) -> None:
        self._link = link
        self._patience_s = patience_s
        self._waits_since_s: float | None = None
        self._sensors = HilSensors(parameters, rng)
        self._commands = np.zeros(ROTORS)
        self._clock_us = -1
        self._awaits_answer = False
        self._reminded_s = time.monotonic()
        self._truth_period_us = self._truth_us = 0
        self._forget_px4()

    @property
    def on_warning(self) -> Callable[[str], None]:
        """Called with a sentence when something is wrong with the link."""
        return self._link.on_warning

    @on_warning.setter
    def on_warning(self, warn: Callable[[str], None]) -> None:
        self._link.on_warning = warn

    @property
    def answers(self) -> bool:
        """Whether PX4 runs in lockstep: it has answered the last measurement."""
        return self._in_lockstep

    def is_ready(self) -> bool:
        """Whether PX4 has connected. Raises Px4Error if it has not within `patience_s`."""
        if self._link.connected or self._link.accept():
            self._waits_since_s = None
            return True
        now_s = time.monotonic()
        self._waits_since_s = now_s if self._waits_since_s is None else self._waits_since_s
        if now_s - self._waits_since_s > self._patience_s:
            raise Px4Error(
                f"No PX4 has connected within {self._patience_s:g} s. {how_to_start(self._link.port)}"
            )
        self._remind()
        return False

    def begin(self, state: VehicleState) -> None:
        """Send a state's measurements to PX4, and do not wait for the answer."""
        self._clock_us = state.time_us
        self._awaits_answer = False
        if not self._link.connected:
            self._forget_px4()
            if not self._link.accept():
                self._remind()
                return
        if state.time_us > 0:  # 0 is no time to PX4
            self._send(state)
            self._awaits_answer = self._link.connected

    def step(self, state: VehicleState) -> np.ndarray:
        """Return the rotor commands (4,), 0..1, that PX4 answers a state with.

        Rotors: front right, rear left, front left, rear right.
        """
        if self._clock_us != state.time_us:
            self.begin(state)
        if self._awaits_answer:
            self._hear()
        return self._commands

    def _remind(self) -> None:
        """Warn from time to time that PX4 is missing."""
        if time.monotonic() - self._reminded_s > _REMINDER_S:
            self._reminded_s = time.monotonic()
            self.on_warning(f"No PX4 is connected. {how_to_start(self._link.port)}")

    def _send(self, state: VehicleState) -> None:
        messages = [self._sensors.sensor(state, self._clock_us), self._sensors.gps(state, self._clock_us)]
        if self._truth_period_us and self._clock_us - self._truth_us >= self._truth_period_us:
            self._truth_us = self._clock_us
            messages.append(self._sensors.truth(state, self._clock_us))
        self._link.send(*(message for message in messages if message is not None))

    def _hear(self) -> None:
        """Wait for the answer to the newest measurement, and handle PX4's other messages."""
        while True:
            messages = self._link.receive(_PATIENCE_S if self._in_lockstep else _REAL_PACE_S)
            if not messages:
                self._miss()
                return
            answers = [self._heed(message) for message in messages]  # every message counts
            if any(answers):
                return

    def _heed(self, message: common.MAVLink_message) -> bool:
        """Handle one message. Return True if it answers the newest measurement."""
        kind = message.get_type()
        if kind == "HIL_ACTUATOR_CONTROLS":
            self._in_lockstep = True
            controls = np.nan_to_num(np.array(message.controls[:ROTORS]), nan=0.0)
            self._commands = np.clip(controls, 0.0, 1.0)
            return message.time_usec >= self._clock_us
        wants = kind == "COMMAND_LONG" and message.command == common.MAV_CMD_SET_MESSAGE_INTERVAL
        if wants and message.param1 == common.MAVLINK_MSG_ID_HIL_STATE_QUATERNION and message.param2 >= 0.0:
            self._truth_period_us = round(min(message.param2, 1e9))
        return False

    def _miss(self) -> None:
        if not self._link.connected:
            self._forget_px4()
        elif self._in_lockstep:
            self.on_warning(
                f"PX4 has not answered a measurement for {_PATIENCE_S:g} s, and simulated time waits for it; "
                "if it hangs, stop it and start it again."
            )

    def _forget_px4(self) -> None:
        self._commands = np.zeros(ROTORS)
        self._in_lockstep = False
        self._truth_period_us = 0
        self._truth_us = 0
        self._sensors.restart()

    def reset(self) -> None:
        """Close the link to this PX4, because its clock and estimate cannot go back.

        The next PX4 starts from zero.
        """
        self._clock_us = -1
        self._forget_px4()
        if self._link.connected:
            self._link.disconnect()
            self.on_warning(
                "The simulation was reset, but a real PX4 cannot be: its connection is closed. Stop it, and "
                f"start it again. {how_to_start(self._link.port)}"
            )

    def close(self) -> None:
        """Close the link."""
        self._link.close()
