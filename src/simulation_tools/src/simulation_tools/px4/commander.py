"""PX4's commander: requested modes, arming and disarming, home.

`wanted_mode` is PX4's main mode, the one that was requested. `mode` is what flies (see `failsafe`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from simulation_tools.geometry import Vector3
from simulation_tools.px4.failsafe import Failsafe, Say, Situation
from simulation_tools.px4.modes import MAIN_MODES, MODE_OF, Mode, Result, Severity
from simulation_tools.px4.parameters import Px4Parameters

_LOCKED_US = 5_000_000  # COM_KILL_DISARM's default
FORCE_MAGIC = 21196.0  # param2 of COMPONENT_ARM_DISARM that disarms in the air


@dataclass(frozen=True)
class Reposition:
    """A new place for hold: NED, and yaw clockwise from north. NaN: this number stays as it is."""

    position_ned_m: Vector3
    yaw_rad: float


class Commander:
    """Decides on mode and arming. Times in microseconds of simulation time."""

    def __init__(self, parameters: Px4Parameters, say: Say) -> None:
        self._parameters = parameters
        self._say = say
        self._failsafe = Failsafe(parameters, say)
        self.mission_is_valid = False
        self.reset()

    def reset(self) -> None:
        """Go back to power-on."""
        self._failsafe.reset()
        self.wanted_mode = Mode.MANUAL
        self.armed = False
        self.home: np.ndarray | None = None
        self.home_yaw_rad = 0.0
        self._home_is_fixed = False
        self.takeoff_altitude_m = math.nan
        self.reposition_target: Reposition | None = None
        self.mode_entries = 0  # rises whenever the flying mode is entered anew
        self._now_us = 0
        self._position = np.zeros(3)
        self._yaw_rad = 0.0
        self._landed = self._maybe_landed = True
        self._position_valid = self._height_valid = False
        self._position_us: int | None = None
        self._setpoint_us: int | None = None
        self._ground_station_us: int | None = None
        self.armed_us = 0
        self._landed_us = 0
        self._flown = False
        self.is_terminated = False
        self._locked_us: int | None = None
        self._seen: tuple[object, ...] = ()  # what was decided on
        self._quiet_until_us = 0.0

    # Inputs

    def setpoint_received(self, now_us: int) -> None:
        """Note a complete offboard setpoint."""
        self._setpoint_us = now_us

    def ground_station_heard(self, now_us: int) -> None:
        """Note a heartbeat of a ground station."""
        self._ground_station_us = now_us

    def update(
        self,
        now_us: int,
        position: np.ndarray,
        yaw_rad: float,
        position_valid: bool,
        height_valid: bool,
        landed: bool,
        maybe_landed: bool,
    ) -> None:
        """Decide, from the estimate (position (3,) and yaw, NED) and the land detector.

        In flight there is nothing to decide until something changes, or until setpoints stay away.
        """
        self._now_us = now_us
        self._position, self._yaw_rad = position, yaw_rad
        if position_valid:
            self._position_us = now_us
        seen = position_valid, height_valid, landed, maybe_landed, self._parameters.revision
        if seen == self._seen and now_us < self._quiet_until_us:
            return
        self._seen = seen
        if position_valid and not self._position_valid:
            self.mode_entries += 1  # an automatic mode that flew blind begins again from here
        self._position_valid = position_valid
        self._height_valid = height_valid
        self._maybe_landed = maybe_landed
        if self.home is None and position_valid:
            self._set_home()
        elif self.home is not None and not self.armed and self.wanted_mode is Mode.MANUAL:
            self.wanted_mode = Mode.AUTO_LOITER  # without a remote control PX4 waits in hold
        self._watch_landing(landed)
        if self.armed and self._locked_us is not None and now_us - self._locked_us >= _LOCKED_US:
            self._disarm("lockdown")
        self._choose_mode()
        self._quiet_until_us = self._next_decision_us

    @property
    def _next_decision_us(self) -> float:
        """When there is something to decide again, if nothing changes and nobody asks for anything."""
        flies = self.armed and not self._landed and self._position_valid and self.home is not None
        waits = self._failsafe.active or self._locked_us is not None or self._parameters["NAV_DLL_ACT"] > 0
        if not flies or waits:
            return self._now_us
        if self.wanted_mode is not Mode.OFFBOARD or self._setpoint_us is None:
            return math.inf
        return self._setpoint_us + 1e6 * self._parameters["COM_OF_LOSS_T"]

    @property
    def mode(self) -> Mode:
        """The mode that flies."""
        return self._failsafe.mode

    @property
    def failsafe(self) -> bool:
        """Whether a failsafe has chosen the mode that flies."""
        return self._failsafe.active

    # Requests

    def request_mode(self, main: int, sub: int) -> Result:
        """Answer DO_SET_MODE with PX4's custom main and sub mode."""
        if main not in MAIN_MODES:
            return Result.ACCEPTED  # PX4 accepts this and changes nothing
        mode = MODE_OF.get((main, sub if main == 4 else 0))
        if mode is None:
            self._say(Severity.CRITICAL, "Unsupported auto mode")
            return Result.TEMPORARILY_REJECTED
        refusal = self._refusal(mode)
        if refusal:
            self._say(Severity.CRITICAL, f"Switching to mode {mode.label} rejected: {refusal}")
            return Result.TEMPORARILY_REJECTED
        if mode is not self.wanted_mode:
            self.takeoff_altitude_m = math.nan
        self.reposition_target = None
        self.wanted_mode = mode
        self._choose_mode()
        return Result.ACCEPTED

    def request_takeoff(self, altitude_m: float) -> Result:
        """Answer NAV_TAKEOFF; altitude over the local frame's origin, NaN for MIS_TAKEOFF_ALT over here."""
        result = self.request_mode(*Mode.AUTO_TAKEOFF.value)
        if result is Result.ACCEPTED:
            self.takeoff_altitude_m = altitude_m
            self.mode_entries += 1
        return result

    def reposition(self, target: Reposition) -> None:
        """Give hold another place, if hold flies."""
        if self.mode is Mode.AUTO_LOITER:
            self.reposition_target = target
            self.mode_entries += 1

    def request_home(self, position_ned_m: Sequence[float] | None) -> Result:
        """Answer DO_SET_HOME; None: here."""
        if not self._position_valid:
            return Result.TEMPORARILY_REJECTED
        if position_ned_m is None:
            self._set_home()
        else:
            self.home, self.home_yaw_rad = np.array(position_ned_m, float), 0.0
            self._home_is_fixed = True  # arming at another place does not move home
        return Result.ACCEPTED

    def take_over(self, mode: Mode, target: Reposition | None = None) -> None:
        """Order a mode, as a low battery and the fence do. target: where AUTO.LOITER holds; None: here."""
        if target is not None:
            self.mode_entries += 1
        self.takeoff_altitude_m = math.nan
        self.reposition_target = target
        self.wanted_mode = mode
        self._choose_mode()

    def terminate(self, lock: bool = False) -> None:
        """Stop the rotors for good. lock: disarm soon, too."""
        self.is_terminated = True
        if lock and self._locked_us is None:
            self._locked_us = self._now_us
            self._quiet_until_us = 0.0

    def end_termination(self) -> None:
        """Let the rotors turn again."""
        self.is_terminated, self._locked_us = False, None

    def takeoff_finished(self) -> None:
        """Hold, or fly the mission, after a take-off has reached its height."""
        if self.wanted_mode is Mode.AUTO_TAKEOFF:
            mission = self._parameters["COM_TAKEOFF_ACT"] == 1 and self.mission_is_valid
            self.wanted_mode = Mode.AUTO_MISSION if mission else Mode.AUTO_LOITER
            self._choose_mode()

    def start_mission(self) -> Result:
        """Answer MISSION_START: fly the mission, and arm."""
        result = self.request_mode(*Mode.AUTO_MISSION.value)
        if result is Result.ACCEPTED and not self.armed:
            result = self.request_arm(reason="mission start")
        return result

    def request_arm(self, force: bool = False, reason: str = "external command") -> Result:
        """Answer COMPONENT_ARM_DISARM 1."""
        if self.armed:
            if self._maybe_landed or force:
                return Result.ACCEPTED
            self._say(Severity.WARNING, "Arming denied! Already armed")
            return Result.DENIED
        manual = self.wanted_mode.is_manual and self._parameters["COM_ARM_WO_GPS"] == 1
        if not (self._height_valid if manual else self._position_valid and self.home is not None):
            self._say(Severity.CRITICAL, "Arming denied: no local position")
            return Result.TEMPORARILY_REJECTED
        self.armed = True
        if self._position_valid and not self._home_is_fixed:
            self._set_home()
        self.armed_us = self._landed_us = self._now_us
        self._flown = False
        self.mode_entries += 1
        self._say(Severity.INFO, f"Armed by {reason}")
        self._choose_mode()
        return Result.ACCEPTED

    def request_disarm(self, force: bool = False) -> Result:
        """Answer COMPONENT_ARM_DISARM 0; in the air only by force."""
        if self.armed and not self._maybe_landed and not force:
            self._say(Severity.CRITICAL, "Disarming denied! Not landed")
            return Result.DENIED
        self._disarm("external command")
        return Result.ACCEPTED

    @property
    def offboard_available(self) -> bool:
        """Whether setpoints have come within COM_OF_LOSS_T."""
        if self._setpoint_us is None:
            return False
        return self._now_us - self._setpoint_us <= 1e6 * self._parameters["COM_OF_LOSS_T"]

    # Decisions

    def _refusal(self, mode: Mode) -> str:
        """Return why a mode cannot be entered; empty when it can."""
        if mode is Mode.AUTO_MISSION and not self.mission_is_valid:
            return "no mission"
        if mode is Mode.OFFBOARD:
            return "" if self.offboard_available else "no offboard setpoints"
        if mode is Mode.ALTCTL:
            return "" if self._height_valid else "no height"
        needs_position = mode.is_auto or mode is Mode.POSCTL
        return "no local position" if needs_position and not self._position_valid else ""

    def _set_home(self) -> None:
        self.home, self.home_yaw_rad = self._position.copy(), self._yaw_rad
        self._home_is_fixed = False

    def _choose_mode(self) -> None:
        """Let the failsafe choose the mode that flies."""
        self._quiet_until_us = 0.0
        before = self.mode
        situation = Situation(
            self._now_us,
            self.armed,
            self._landed,
            self.offboard_available,
            self._ground_station_is_there,
            self._had_position_lately,
        )
        self.wanted_mode = self._failsafe.choose(self.wanted_mode, situation)
        if self.mode is not before:
            self.mode_entries += 1

    @property
    def _had_position_lately(self) -> bool:
        valid_us = self._position_us
        return valid_us is not None and self._now_us - valid_us <= 1e6 * self._parameters["COM_POS_FS_DELAY"]

    @property
    def _ground_station_is_there(self) -> bool:
        heard = self._ground_station_us
        return heard is not None and self._now_us - heard <= 1e6 * self._parameters["COM_DL_LOSS_T"]

    def _watch_landing(self, landed: bool) -> None:
        """Note take-off and landing. Disarm some time after a landing, or after arming without a take-off."""
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
