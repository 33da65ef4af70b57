"""ArduPilot SITL as the simulator's flight controller, in lockstep with the physics."""

from __future__ import annotations

import math
import time
from typing import Callable

import numpy as np

from simulation_tools.ardupilot_sitl.json_link import JsonLink, ServoFrame
from simulation_tools.ardupilot_sitl.json_sensors import JsonSensors
from simulation_tools.ardupilot_sitl.program import FRAME_RATE_HZ, Program
from simulation_tools.autopilot import AutopilotError, VehicleState

ROTORS = 4
FRAME_US = 1_000_000 // FRAME_RATE_HZ
_LONGEST_US = 20_000  # a longer step is told as one frame: ArduPilot was away
_PATIENCE_S = 1.5  # wall time; it asks again after 1 s
_RESTART_S = 1.0  # wall time
_LEAST_LIFE_S = 5.0  # wall time; a program that ends sooner without a frame will not do better
_TRIES = 3


class ArduPilotSitl:
    """An `Autopilot` whose commands come from the ArduPilot at the other end of a link.

    Each step of the physics is told as frames of 1 ms, because ArduPilot's gyroscopes count as inconsistent
    below some 720 Hz. ArduPilot's clock follows the frames, also if it starts later than simulated time.
    When the program ends, the rotors stop, and it is started again. A reset starts it again, too, because its
    clock cannot go back.

    program: what to start with the first call of `is_ready`; None: the user starts ArduPilot. So a simulation
    that cannot be made, or is interrupted before it begins, leaves nothing behind. patience_s: wall time
    after which a missing ArduPilot is an error.
    """

    def __init__(
        self, link: JsonLink, sensors: JsonSensors, program: Program | None, patience_s: float = math.inf
    ) -> None:
        self.on_warning: Callable[[str], None] = lambda sentence: None
        self._link = link
        self._sensors = sensors
        self._program = program
        self._patience_s = patience_s
        self._before = VehicleState(0)
        self._told_us = 0
        self._asked: ServoFrame | None = None
        self._commands = np.zeros(ROTORS)
        self._tries = 0
        self._waits_since_s = time.monotonic()
        self._restart_s = math.inf  # wall time
        self._has_checked_version = False
        self._has_begun = False
        link.on_warning = lambda sentence: self.on_warning(sentence)

    @property
    def answers(self) -> bool:
        """Whether ArduPilot runs in lockstep."""
        return self._link.connected

    def is_ready(self) -> bool:
        """Whether ArduPilot has sent its first frame; raises AutopilotError if it has not in `patience_s`."""
        if not self._has_begun:
            self._has_begun = True
            self._start()
        if self._asked is None:
            self._asked = self._link.receive(0.0)
        if self._asked is not None:
            return True
        self._look_after_program()
        if time.monotonic() - self._waits_since_s > self._patience_s:
            raise AutopilotError(
                f"No ArduPilot has sent a frame to UDP port {self._link.port} within {self._patience_s:g} s."
            )
        return False

    def begin(self, state: VehicleState) -> None:
        """Answer the frame that ArduPilot has asked for, and do not wait for the next one."""
        if self._asked is not None and self._told_us < state.time_us:
            self._tell(state)

    def step(self, state: VehicleState) -> np.ndarray:
        """Return the rotor commands (4,), 0..1, with which ArduPilot answers a state.

        Rotors: front right, rear left, front left, rear right.
        """
        while True:
            if self._asked is None:
                self._asked = self._link.receive(_PATIENCE_S if self._link.connected else 0.0)
            if self._asked is None:
                self._miss()
                break
            if self._told_us >= state.time_us:
                self._commands = _commands_of(self._asked)
                self._check_version()
                break
            self._tell(state)
        self._before = state
        return self._commands

    def _tell(self, state: VehicleState) -> None:
        """Tell the next frame on the way to a state."""
        left_us = state.time_us - self._told_us
        self._told_us = self._told_us + FRAME_US if left_us < _LONGEST_US else state.time_us
        self._told_us = min(self._told_us, state.time_us)
        self._link.answer(self._sensors.line(self._before, state, self._told_us))
        self._asked = None

    def _miss(self) -> None:
        if self._program is not None and not self._program.runs:
            self._look_after_program()
        elif self._link.connected:
            self.on_warning(
                f"ArduPilot has asked for no frame for {_PATIENCE_S:g} s, and simulated time waits for it; "
                "if it hangs, end its process, and it is started again."
            )

    def _look_after_program(self) -> None:
        """Notice the program's end, and start it again a little later."""
        program = self._program
        if program is None or program.runs:
            return
        now_s = time.monotonic()
        if self._restart_s == math.inf:
            self._note_end(program)
            self._restart_s = now_s + _RESTART_S
        elif now_s >= self._restart_s:
            self._restart_s = math.inf
            program.start()

    def _note_end(self, program: Program) -> None:
        came = self._link.connected
        self._tries = 0 if came else self._tries + 1
        said = program.last_words()
        sentence = (
            f"ArduPilot has ended (exit status {program.exit_status}). Its last words: {said or 'none'}"
        )
        self._forget()
        if self._tries >= _TRIES or (not came and time.monotonic() - program.started_s < _LEAST_LIFE_S):
            raise AutopilotError(f"{sentence}. Is it arducopter of ArduPilot 4.6, built for the board sitl?")
        self.on_warning(f"{sentence}. The rotors stop, and it is started again.")

    def _check_version(self) -> None:
        """Warn once if the program does not know all of our parameters."""
        if self._has_checked_version or self._program is None or self._told_us < 3_000_000:
            return
        self._has_checked_version = True
        unknown = self._program.unknown_parameters()
        if unknown:
            self.on_warning(
                f"This ArduPilot does not know the parameters {', '.join(unknown)}; the simulator is made "
                "for ArduPilot Copter 4.6."
            )

    def _forget(self) -> None:
        self._link.forget()
        self._sensors.restart()
        self._asked = None
        self._commands = np.zeros(ROTORS)
        self._waits_since_s = time.monotonic()

    def reset(self) -> None:
        """Start ArduPilot again; simulated time begins at 0."""
        if self._program is not None:
            self._program.stop()  # first: what it has asked for meanwhile must be forgotten, too
        self._forget()
        self._before, self._told_us, self._restart_s = VehicleState(0), 0, math.inf
        if self._has_begun:
            self._start()

    def _start(self) -> None:
        self._waits_since_s = time.monotonic()
        if self._program is not None:
            self._program.start()

    def close(self) -> None:
        """End ArduPilot, and close the link."""
        if self._program is not None:
            self._program.stop()
        self._link.close()


def _commands_of(frame: ServoFrame) -> np.ndarray:
    """Pulses of 1000 to 2000 us to commands of 0 to 1. No pulse is no command."""
    return np.clip((np.array(frame.pulses_us[:ROTORS], dtype=float) - 1000.0) / 1000.0, 0.0, 1.0)
