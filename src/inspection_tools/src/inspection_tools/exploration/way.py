"""The places that a UAV flies to one after the other."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

NEARER_M = 0.1
"""A UAV whose way gets so much shorter makes progress."""
STAYS_M = 1.0
"""A UAV stays where it is while it is no farther from there."""
SAME_M = 0.3
"""Ways whose ends are nearer than this have the same goal."""


class Progress:
    """Whether a UAV comes nearer to its goal, whichever way it takes."""

    def __init__(self) -> None:
        self._goal_m: np.ndarray | None = None
        self._least_m, self._nearer_s = math.inf, math.nan

    def note(self, stamp_s: float, here_m: np.ndarray, rest_m: Sequence[np.ndarray]) -> None:
        """Take a pose (x, y, z), and the places that are still to come."""
        if not rest_m:
            self._goal_m = None
            return
        way_m = sum(math.dist(a, b) for a, b in zip((here_m, *rest_m), rest_m))
        is_new = self._goal_m is None or math.dist(self._goal_m, rest_m[-1]) > SAME_M
        if is_new or way_m < self._least_m - NEARER_M:
            self._goal_m, self._least_m, self._nearer_s = rest_m[-1], way_m, stamp_s

    def is_held_off(self, stamp_s: float, time_s: float) -> bool:
        """Whether it has come no nearer for so long."""
        return self._goal_m is not None and stamp_s - self._nearer_s > time_s


class Stay:
    """For how long a UAV has stayed where it is."""

    def __init__(self) -> None:
        self._place_m: np.ndarray | None = None
        self._since_s = math.inf

    def note(self, stamp_s: float, here_m: np.ndarray) -> None:
        """Take a pose (x, y, z)."""
        if self._place_m is None or math.dist(here_m, self._place_m) > STAYS_M:
            self._place_m, self._since_s = here_m, stamp_s

    def lasts(self, stamp_s: float, time_s: float) -> bool:
        """Whether it has stayed for so long."""
        return stamp_s - self._since_s > time_s


class Way:
    """A way that one thread follows. Another one may replace it at any time, but does not change it.

    Args:
        places_m: (x, y, z) each, without the place where the UAV is.
    """

    def __init__(self, places_m: Sequence[np.ndarray] = ()) -> None:
        self._places_m, self._reached = tuple(places_m), 0

    def follow(self, here_m: np.ndarray, arrived_m: float) -> None:
        """Go on to the next place if the UAV (x, y, z) is nearer than this to the present one."""
        if self.is_left and math.dist(here_m, self._places_m[self._reached]) < arrived_m:
            self._reached += 1

    @property
    def is_left(self) -> bool:
        """Whether the UAV has not arrived at the end."""
        return self._reached < len(self._places_m)

    @property
    def rest_m(self) -> list[np.ndarray]:
        """The places to come."""
        return list(self._places_m[self._reached :])

    @property
    def setpoint_m(self) -> np.ndarray | None:
        """The place to fly to now, in the end the last one; None: the way has none."""
        return self._places_m[min(self._reached, len(self._places_m) - 1)] if self._places_m else None


def in_steps(places_m: Sequence[np.ndarray], step_m: float) -> list[np.ndarray]:
    """Return the places (x, y, z) of a way with others between, so that no step is longer than this."""
    stepped = [np.asarray(place_m, float) for place_m in places_m[:1]]
    for begin_m, end_m in zip(places_m, places_m[1:]):
        count = max(1, math.ceil(math.dist(begin_m, end_m) / step_m))
        stepped += [begin_m + share * (end_m - begin_m) for share in np.linspace(0.0, 1.0, count + 1)[1:]]
    return stepped
