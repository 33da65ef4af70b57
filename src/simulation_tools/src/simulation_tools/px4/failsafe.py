"""Chooses the mode that flies: the requested one, or a failsafe's when something is lost.

PX4 has two modes. The *main mode* was requested. The *navigation mode* flies. They differ only in a
failsafe. When the lost link or stream is back, they are equal again. There is one exception: a return after
the loss of a link becomes the main mode.

Without a local position only landing is left; it then sinks wherever the vehicle drifts.

There is no remote control here, so its signal counts as lost from the start. Real PX4 would then also return
from a hold in the air when it hears no ground station. Here it does so only if NAV_DLL_ACT asks for it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, NamedTuple

from simulation_tools.px4.modes import Mode, Severity
from simulation_tools.px4.parameters import Px4Parameters

Say = Callable[[Severity, str], None]

_LINK_LOSS_ACTIONS: dict[float, Mode | None] = {
    0: None,
    1: Mode.AUTO_LOITER,
    2: Mode.AUTO_RTL,
    3: Mode.AUTO_LAND,
}
_OFFBOARD_LOSS_ACTIONS: dict[float, Mode | None] = {
    -1: None,
    0: Mode.AUTO_LAND,
    1: Mode.AUTO_LOITER,
    2: Mode.AUTO_RTL,
}
_SAME_FAILSAFE_S = 30.0  # if a failsafe returns within this time, it continues the last one's waiting time


class Situation(NamedTuple):
    """The inputs of the decision.

    now_us: simulation time. has_setpoints: offboard setpoints arrive. has_ground_station: its heartbeats
    arrive. has_position: there is a local position, or there was one COM_POS_FS_DELAY ago.
    """

    now_us: int
    armed: bool
    landed: bool
    has_setpoints: bool
    has_ground_station: bool
    has_position: bool = True


@dataclass(frozen=True)
class _Loss:
    """A loss and the mode that it causes; None: the mode stays. wait_s: time of hold before."""

    reason: str
    action: Mode | None
    wait_s: float = 0.0
    is_link: bool = True


class Failsafe:
    """Chooses the navigation mode, `mode`; `active` says whether it is a failsafe's."""

    def __init__(self, parameters: Px4Parameters, say: Say) -> None:
        self._parameters = parameters
        self._say = say
        self.reset()

    def reset(self) -> None:
        """Go back to power-on."""
        self.mode = Mode.MANUAL
        self.active = False
        self._began_us: int | None = None

    def choose(self, main_mode: Mode, situation: Situation) -> Mode:
        """Set `mode` and `active`; returns the main mode, which changes when a lost link makes it return."""
        was_active = self.active
        loss = self._loss(main_mode, situation)
        self.active = loss is not None
        if loss is None:
            self.mode = main_mode
        else:
            if situation.armed and not was_active:
                self._begin(loss.reason, situation.now_us)
            main_mode = self._react(loss, main_mode, situation.now_us)
            if not situation.has_position and self.mode.needs_position:
                self.mode = Mode.AUTO_LAND
        if self.active is not was_active:
            self._say(Severity.INFO, f"Failsafe mode {'' if self.active else 'de'}activated")
        return main_mode

    def _begin(self, reason: str, now_us: int) -> None:
        if self._began_us is None or now_us - self._began_us > 1e6 * _SAME_FAILSAFE_S:
            self._began_us = now_us
        self._say(Severity.CRITICAL, f"Failsafe enabled: {reason}")

    def _react(self, loss: _Loss, main_mode: Mode, now_us: int) -> Mode:
        waiting = self._began_us is not None and now_us - self._began_us < 1e6 * loss.wait_s
        if waiting and loss.action is not None:
            self.mode = Mode.AUTO_LOITER
        elif loss.action is not None:
            self.mode = loss.action
            if loss.is_link and loss.action is Mode.AUTO_RTL:
                return Mode.AUTO_RTL
        return main_mode

    def _loss(self, main_mode: Mode, situation: Situation) -> _Loss | None:
        """Return the main mode's loss, or None."""
        p = self._parameters
        if main_mode is Mode.OFFBOARD:
            if situation.has_setpoints:
                return None
            action = _OFFBOARD_LOSS_ACTIONS.get(p["COM_OBL_ACT"], Mode.AUTO_LAND)
            return _Loss("no RC and no offboard", action, is_link=False)
        if main_mode.is_manual and situation.armed:
            action = _LINK_LOSS_ACTIONS.get(p["NAV_RCL_ACT"], Mode.AUTO_LAND)
            return _Loss("No manual control stick input", action, p["COM_RCL_ACT_T"])
        if main_mode.needs_position and situation.armed and not situation.has_position:
            return _Loss("no local position", Mode.AUTO_LAND, is_link=False)
        needs_link = main_mode in (Mode.AUTO_LOITER, Mode.AUTO_TAKEOFF, Mode.AUTO_MISSION)
        flies = needs_link and situation.armed and not situation.landed
        if flies and p["NAV_DLL_ACT"] > 0 and not situation.has_ground_station:
            return _Loss("no datalink", _LINK_LOSS_ACTIONS.get(p["NAV_DLL_ACT"], Mode.AUTO_LAND))
        return None
