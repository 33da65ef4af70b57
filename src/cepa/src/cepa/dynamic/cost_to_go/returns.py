"""Notices that a UAV has come back to where it was: no choice of a way has led it on."""

from __future__ import annotations

import math
from collections import deque

from cepa.dynamic.constants.cost_to_go import (
    CLEAR_S,
    PAUSE_S,
    RETURN_APART_M,
    RETURN_S,
    RETURN_STEP_M,
    RETURN_WAY_M,
    RETURNS_S,
)


class Returns:
    """Keeps the UAV's trail, and when it has met it again.

    A UAV that leaves a dead end meets its trail once, because the trail begins anew there. One that wavers
    between two ways meets it again and again.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget the trail and all returns."""
        self._trail: deque[tuple[float, float, float, float]] = deque()  # stamp, x, y, way
        self._way_m = 0.0
        self._asked_s = self._wanted_s = -math.inf  # when it was asked to fly, and wanted a way around
        self._met_s: deque[float] = deque()

    def number(self, stamp_s: float) -> int:
        """Return how often the UAV has come back in the last RETURNS_S."""
        while self._met_s and self._met_s[0] < stamp_s - RETURNS_S:
            self._met_s.popleft()
        return len(self._met_s)

    def last_s(self) -> float:
        """Return when it came back last, s; -inf: never."""
        return self._met_s[-1] if self._met_s else -math.inf

    def direction(self) -> tuple[float, float] | None:
        """Return the unit vector of the trail's last step; None: there is none yet."""
        if len(self._trail) < 2:
            return None
        (_, x_0, y_0, _), (_, x_1, y_1, _) = self._trail[-2], self._trail[-1]
        step_m = math.hypot(x_1 - x_0, y_1 - y_0)
        return (x_1 - x_0) / step_m, (y_1 - y_0) / step_m

    def fly_clear(self, stamp_s: float) -> None:
        """Take in that the way is clear, and the UAV flies it: for a moment only it is no other flight."""
        is_same = 0.0 <= stamp_s - self._asked_s <= PAUSE_S
        if is_same and stamp_s - self._wanted_s <= CLEAR_S:
            self._asked_s = stamp_s

    def meets(self, stamp_s: float, x_m: float, y_m: float) -> bool:
        """Take in where the UAV is; return whether it has just come back to its trail."""
        paused_s, self._asked_s = stamp_s - self._asked_s, stamp_s
        if not 0.0 <= paused_s <= PAUSE_S:  # it was asked to hover: what follows is another flight
            self.reset()
            self._asked_s = stamp_s
        self._wanted_s = stamp_s
        if not self._trail:
            self._trail.append((stamp_s, x_m, y_m, 0.0))
            return False
        _, last_x, last_y, _ = self._trail[-1]
        step_m = math.hypot(x_m - last_x, y_m - last_y)
        if step_m < RETURN_STEP_M:
            return False
        self._way_m += step_m
        while self._trail and self._trail[0][0] < stamp_s - RETURN_S:
            self._trail.popleft()
        came_back = any(
            self._way_m - way_m >= RETURN_WAY_M and math.hypot(x_m - x, y_m - y) < RETURN_APART_M
            for _, x, y, way_m in self._trail
        )
        if came_back:
            self._trail.clear()
            self._trail.append((stamp_s, last_x, last_y, self._way_m))
            self._met_s.append(stamp_s)
        self._trail.append((stamp_s, x_m, y_m, self._way_m))
        return came_back
