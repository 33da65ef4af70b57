"""PX4's commander: which mode flies, arming, and what happens when something is lost.

The *wanted* mode is what somebody asked for; the mode that flies differs from it in a failsafe, and is the
wanted one again as soon as what was lost is back.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Sequence

import numpy as np

from simulation_tools.geometry import Vector3
from simulation_tools.px4.modes import MAIN_MODES, Mode, Result, Severity
from simulation_tools.px4.parameters import Px4Parameters

FORCE_MAGIC = 21196.0  # param2 of COMPONENT_ARM_DISARM that disarms in the air
_LOSS_ACTIONS = {1: Mode.AUTO_LOITER, 2: Mode.AUTO_RTL, 3: Mode.AUTO_LAND}
_OFFBOARD_LOSS_ACTIONS = {0: Mode.AUTO_LAND, 1: Mode.AUTO_LOITER, 2: Mode.AUTO_RTL}

Say = Callable[[Severity, str], None]


@dataclass(frozen=True)
class Reposition:
    """Where hold is to go: NED and yaw (clockwise from north), NaN for what is to stay."""

    position_ned_m: Vector3
    yaw_rad: float


class Commander:
    """Decides on mode and arming. Times in microseconds of simulation time."""

    def __init__(self, parameters: Px4Parameters, say: Say) -> None:
        self._parameters = parameters
        self._say = say
        self.reset()

    def reset(self) -> None:
        """Go back to power-on."""
        self.mode = Mode.MANUAL  # what flies
        self.wanted_mode = Mode.MANUAL
        self.failsafe = False
        self.armed = False
        self.home: np.ndarray | None = None
        self.takeoff_height_m = math.nan
        self.reposition_target: Reposition | None = None
        self.mode_entries = 0  # rises whenever the flying mode is entered anew
        self._now_us = 0
        self._position = np.zeros(3)
        self._landed = True
        self._position_valid = False
        self._mode_was_asked_for = False
        self._setpoint_us: int | None = None
        self._ground_station_us: int | None = None
        self.armed_us = 0
        self._landed_us = 0
        self._flown = False

    # What happens

    def setpoint_received(self, now_us: int) -> None:
        """Note an offboard setpoint that asks for something."""
        self._setpoint_us = now_us

    def ground_station_heard(self, now_us: int) -> None:
        """Note a heartbeat of a ground station."""
        self._ground_station_us = now_us

    def update(self, now_us: int, position: np.ndarray, position_valid: bool, landed: bool) -> None:
        """Take in the estimate (position (3,) NED) and decide."""
        self._now_us = now_us
        self._position = position
        self._position_valid = position_valid
        if self.home is None and position_valid:
            self.home = position.copy()
        elif self.home is not None and not self._mode_was_asked_for and self.wanted_mode is Mode.MANUAL:
            self.wanted_mode = Mode.AUTO_LOITER  # without a remote control PX4 waits in hold
        self._watch_landing(landed)
        self._choose_mode()

    # What is asked for

    def request_mode(self, main: int, sub: int) -> Result:
        """Answer DO_SET_MODE with PX4's custom main and sub mode."""
        if main not in MAIN_MODES:
            return Result.ACCEPTED  # PX4 says so, and changes nothing
        try:
            mode = Mode((main, sub if main == 4 else 0))
        except ValueError:
            self._say(Severity.CRITICAL, f"Unsupported auto mode {sub}")
            return Result.TEMPORARILY_REJECTED
        refusal = self._refusal(mode)
        if refusal:
            self._say(Severity.CRITICAL, f"Switching to mode {mode.label} rejected: {refusal}")
            return Result.TEMPORARILY_REJECTED
        self._mode_was_asked_for = True
        if mode is not self.wanted_mode:
            self.takeoff_height_m = math.nan
        self.reposition_target = None
        self.wanted_mode = mode
        self._choose_mode()
        return Result.ACCEPTED

    def request_takeoff(self, height_m: float) -> Result:
        """Answer NAV_TAKEOFF; height over home, NaN for MIS_TAKEOFF_ALT."""
        result = self.request_mode(*Mode.AUTO_TAKEOFF.value)
        if result is Result.ACCEPTED:
            self.takeoff_height_m = height_m
            self.mode_entries += 1
        return result

    def reposition(self, target: Reposition) -> None:
        """Give hold another place, if hold is what flies."""
        if self.mode is Mode.AUTO_LOITER:
            self.reposition_target = target
            self.mode_entries += 1

    def request_home(self, position_ned_m: Sequence[float] | None) -> Result:
        """Answer DO_SET_HOME; None: here."""
        if not self._position_valid:
            return Result.TEMPORARILY_REJECTED
        self.home = self._position.copy() if position_ned_m is None else np.array(position_ned_m, float)
        return Result.ACCEPTED

    def takeoff_finished(self) -> None:
        """Hold, after a take-off has reached its height."""
        if self.wanted_mode is Mode.AUTO_TAKEOFF:
            self.wanted_mode = Mode.AUTO_LOITER
            self._choose_mode()

    def request_arm(self, force: bool = False) -> Result:
        """Answer COMPONENT_ARM_DISARM 1."""
        if self.armed:
            return Result.ACCEPTED
        if not self._position_valid or self.home is None:
            self._say(Severity.CRITICAL, "Arming denied: no local position")
            return Result.TEMPORARILY_REJECTED
        if self.wanted_mode is Mode.OFFBOARD and not self.offboard_available and not force:
            self._say(Severity.CRITICAL, "Arming denied: no offboard setpoints")
            return Result.TEMPORARILY_REJECTED
        self.armed = True
        self.home = self._position.copy()
        self.armed_us = self._landed_us = self._now_us
        self._flown = False
        self.mode_entries += 1
        self._say(Severity.INFO, "Armed by external command")
        self._choose_mode()
        return Result.ACCEPTED

    def request_disarm(self, force: bool = False) -> Result:
        """Answer COMPONENT_ARM_DISARM 0; in the air only by force."""
        if self.armed and not self._landed and not force:
            self._say(Severity.CRITICAL, "Disarming denied: not landed")
            return Result.DENIED
        self._disarm("external command")
        return Result.ACCEPTED

    @property
    def offboard_available(self) -> bool:
        """Whether setpoints have come within COM_OF_LOSS_T."""
        if self._setpoint_us is None:
            return False
        return self._now_us - self._setpoint_us <= 1e6 * self._parameters["COM_OF_LOSS_T"]

    @property
    def has_flown(self) -> bool:
        """Whether it has left the ground since it was armed."""
        return self._flown

    # Decisions

    def _refusal(self, mode: Mode) -> str:
        """Return why a mode cannot be entered; empty when it can."""
        if mode is Mode.AUTO_MISSION:
            return "no mission"
        if mode is Mode.OFFBOARD:
            return "" if self.offboard_available else "no offboard setpoints"
        needs_position = mode.is_auto or mode in (Mode.POSCTL, Mode.ALTCTL)
        return "no local position" if needs_position and not self._position_valid else ""

    def _choose_mode(self) -> None:
        """Set the flying mode and the failsafe flag from the wanted mode and what is lost."""
        mode, failsafe, reason = self.wanted_mode, False, ""
        if self.armed:
            p = self._parameters
            if mode is Mode.OFFBOARD and not self.offboard_available and p["COM_OBL_ACT"] >= 0:
                mode = _OFFBOARD_LOSS_ACTIONS.get(p["COM_OBL_ACT"], Mode.AUTO_LAND)
                failsafe, reason = True, "no offboard setpoints"
            elif mode.is_manual and p["NAV_RCL_ACT"] > 0:
                mode = _LOSS_ACTIONS.get(p["NAV_RCL_ACT"], Mode.AUTO_LAND)
                failsafe, reason = True, "no remote control"
            elif mode in (Mode.AUTO_LOITER, Mode.AUTO_TAKEOFF) and self._ground_station_lost():
                mode = _LOSS_ACTIONS.get(p["NAV_DLL_ACT"], Mode.AUTO_LAND)
                failsafe, reason = True, "no datalink"
        if failsafe and not self.failsafe:
            self._say(Severity.CRITICAL, f"Failsafe enabled: {reason}")
        elif self.failsafe and not failsafe:
            self._say(Severity.INFO, "Failsafe disabled")
        if mode is not self.mode:
            self.mode_entries += 1
        self.mode, self.failsafe = mode, failsafe

    def _ground_station_lost(self) -> bool:
        p = self._parameters
        if p["NAV_DLL_ACT"] == 0 or self._landed:
            return False
        heard = self._ground_station_us
        return heard is None or self._now_us - heard > 1e6 * p["COM_DL_LOSS_T"]

    def _watch_landing(self, landed: bool) -> None:
        """Notice take-off and landing, and disarm some time after a landing or an arming without take-off."""
        p = self._parameters
        if landed and not self._landed:
            self._landed_us = self._now_us
            self._say(Severity.INFO, "Landing detected")
        elif self._landed and not landed:
            self._flown = True
            self._say(Severity.INFO, "Takeoff detected")
        self._landed = landed
        if not (self.armed and landed):
            return
        if self._flown:
            if 0.0 < p["COM_DISARM_LAND"] <= 1e-6 * (self._now_us - self._landed_us):
                self._disarm("landing")
        elif 0.0 < p["COM_DISARM_PRFLT"] <= 1e-6 * (self._now_us - self.armed_us):
            self._disarm("auto preflight disarming")

    def _disarm(self, reason: str) -> None:
        if self.armed:
            self._say(Severity.INFO, f"Disarmed by {reason}")
        self.armed = False
        self._flown = False
        self._choose_mode()
