"""Whether a mission can be flown: PX4's checks when it is uploaded and when home becomes known.

MAVLink's protocol takes a mission whatever these checks say. A mission that fails them is not flown.
"""

from __future__ import annotations

import math
from typing import Callable, Sequence

import numpy as np

from simulation_tools.geodesy import GeodeticOrigin
from simulation_tools.px4.failsafe import Say
from simulation_tools.px4.modes import Severity
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.plan.items import PAYLOAD_COMMANDS, Command, PlanItem

_REFUSED = (Command.CONDITION_DELAY, Command.CONDITION_DISTANCE)
_MIN_CLIMB_M = 1.0  # a take-off must rise by this above its acceptance radius
_BEFORE_TAKEOFF = (
    Command.DELAY,
    Command.JUMP,
    Command.CHANGE_SPEED,
    Command.SET_HOME,
    Command.LAND_START,
    Command.SET_ROI,
    Command.SET_ROI_LOCATION,
    Command.SET_ROI_NONE,
)


class FeasibilityCheck:
    """Checks missions. Says what is wrong with one."""

    def __init__(
        self, parameters: Px4Parameters, fence_allows: Callable[[Sequence[float]], bool], say: Say
    ) -> None:
        """fence_allows: whether a place, NED, lies inside the fence."""
        self._parameters = parameters
        self._fence_allows = fence_allows
        self._say = say

    def passes(
        self, items: Sequence[PlanItem], home: np.ndarray | None, origin: GeodeticOrigin, landed: bool
    ) -> bool:
        """Whether a mission can be flown from home, NED (3,)."""
        if not items:
            return False
        if home is None:
            self._say(Severity.INFO, "Not yet ready for mission, no position lock.")
            return False
        places = [
            item.position_ned_m(origin, float(home[2])) if item.has_position else None for item in items
        ]
        refusal = (
            self._too_far(places, home)
            or _unsupported(items, landed)
            or self._outside(places)
            or self._bad_takeoff(items, places, home, landed)
        )
        if refusal:
            self._say(Severity.CRITICAL, refusal)
            return False
        self._warn(items, places, home)
        return True

    def _too_far(self, places: Sequence[Sequence[float] | None], home: np.ndarray) -> str:
        p = self._parameters
        flown = [place for place in places if place is not None]
        most_m = p["MIS_DIST_1WP"]
        if flown and most_m > 0.0:
            distance_m = math.hypot(flown[0][0] - home[0], flown[0][1] - home[1])
            if distance_m >= most_m:
                return f"First waypoint too far away: {int(distance_m)}m, {int(most_m)} max"
        most_m = p["MIS_DIST_WPS"]
        for before, after in zip(flown, flown[1:]):
            distance_m = math.hypot(after[0] - before[0], after[1] - before[1])
            if 0.0 < most_m < distance_m:
                return f"Distance between waypoints too far: {int(distance_m)} meters, {int(most_m)} max."
        return ""

    def _outside(self, places: Sequence[Sequence[float] | None]) -> str:
        for number, place in enumerate(places, 1):
            if place is not None and not self._fence_allows(place):
                return f"Geofence violation for waypoint {number}"
        return ""

    def _bad_takeoff(
        self,
        items: Sequence[PlanItem],
        places: Sequence[Sequence[float] | None],
        home: np.ndarray,
        landed: bool,
    ) -> str:
        p = self._parameters
        indices = [i for i, item in enumerate(items) if item.command == Command.TAKEOFF]
        for place in (places[i] for i in indices):
            if place is not None and home[2] - place[2] - _MIN_CLIMB_M < p["NAV_ACC_RAD"]:
                return "Mission rejected: Takeoff altitude too low!"
        if p["MIS_TAKEOFF_REQ"] == 1 and landed:
            if not indices:
                return "Mission rejected: takeoff waypoint required."
            before = [item.command for item in items[: indices[0]]]
            if any(command not in _BEFORE_TAKEOFF and command not in PAYLOAD_COMMANDS for command in before):
                return "Mission rejected: takeoff not first waypoint item"
        return ""

    def _warn(
        self, items: Sequence[PlanItem], places: Sequence[Sequence[float] | None], home: np.ndarray
    ) -> None:
        for number, (item, place) in enumerate(zip(items, places), 1):
            if place is not None and place[2] > home[2]:
                self._say(Severity.CRITICAL, f"Warning: Waypoint {number} below home")
            if item.command in PAYLOAD_COMMANDS:
                self._say(
                    Severity.WARNING,
                    f"Mission item {number}: no payload here, command {item.command} ignored",
                )


def _unsupported(items: Sequence[PlanItem], landed: bool) -> str:
    for number, item in enumerate(items, 1):
        if item.command in _REFUSED:
            return f"Mission rejected: item {number}: unsupported cmd: {item.command}"
    if landed and items[0].command == Command.LAND:
        return "Mission rejected: starts with landing"
    return ""
