"""What a metre of a way takes, by what this flight has needed for its ways so far."""

from __future__ import annotations

import math
from enum import Enum
from typing import Sequence

import numpy as np

SUPPOSED_M = 10.0
"""So many metres of each course are taken as flown as supposed. Else the first stop would count for all."""
SAME_M = 0.3
"""Ways whose ends are nearer than this have the same goal."""
LONGEST_S = 10.0
"""A longer time between two poses tells of no flight."""


class Course(Enum):
    """Where a leg leads. One that rises or sinks by more than it leads aside is not level."""

    LEVEL = "level"
    UP = "up"
    DOWN = "down"


class Pace:
    """Learns what a metre of a planned way takes, level, up and down apart; never less than supposed.

    What counts is how much shorter the way to a goal gets, not how far the UAV flies: so stops and detours
    count, too. CEPA looks before it lets a UAV sink, which may take three times as long as supposed.

    Args:
        speed_m_s: supposed, along a way.
    """

    def __init__(self, speed_m_s: float) -> None:
        self._supposed_s = 1.0 / speed_m_s
        self._needed_s = dict.fromkeys(Course, 0.0)
        self._gained_m = dict.fromkeys(Course, 0.0)
        self._goal_m: np.ndarray | None = None
        self._before: tuple[float, dict[Course, float]] | None = None
        """When the way was as short as never before, and its metres then."""

    def note(self, stamp_s: float, here_m: np.ndarray, rest_m: Sequence[np.ndarray]) -> None:
        """Take a pose (x, y, z), and the places of its way that are still to come; none: it is on no way."""
        if not rest_m:
            self._goal_m = self._before = None
            return
        left_m = metres_by_course(np.array([here_m, *rest_m]))
        is_same = self._goal_m is not None and math.dist(self._goal_m, rest_m[-1]) <= SAME_M
        if not is_same or self._before is None or not 0.0 <= stamp_s - self._before[0] <= LONGEST_S:
            self._goal_m, self._before = rest_m[-1], (stamp_s, left_m)
            return
        before_s, before_m = self._before
        gained_m = sum(before_m.values()) - sum(left_m.values())
        if gained_m <= 0.0:
            return
        of_course = {course: max(before_m[course] - left_m[course], 0.0) for course in Course}
        share = gained_m / max(sum(of_course.values()), 1e-9)  # below 1 where a new way has other courses
        for course, metres in of_course.items():
            self._gained_m[course] += share * metres
            self._needed_s[course] += (stamp_s - before_s) * metres / max(sum(of_course.values()), 1e-9)
        self._goal_m, self._before = rest_m[-1], (stamp_s, left_m)

    def of(self, course: Course) -> float:
        """Return what a metre of a course takes, s."""
        supposed_s = SUPPOSED_M * self._supposed_s
        learned_s = (supposed_s + self._needed_s[course]) / (SUPPOSED_M + self._gained_m[course])
        return max(self._supposed_s, learned_s)

    def time_s(self, way_m: np.ndarray) -> float:
        """Return what a way (n, 3) takes, s."""
        return sum(metres * self.of(course) for course, metres in metres_by_course(way_m).items())


def metres_by_course(way_m: np.ndarray) -> dict[Course, float]:
    """Return the length of a way (n, 3) by its courses, m."""
    legs_m = np.diff(way_m, axis=0)
    lengths_m, rises_m = np.linalg.norm(legs_m, axis=1), legs_m[:, 2]
    is_level = np.abs(rises_m) <= np.hypot(legs_m[:, 0], legs_m[:, 1])
    return {
        Course.LEVEL: float(lengths_m[is_level].sum()),
        Course.UP: float(lengths_m[~is_level & (rises_m > 0.0)].sum()),
        Course.DOWN: float(lengths_m[~is_level & (rises_m < 0.0)].sum()),
    }
