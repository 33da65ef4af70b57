"""The side to which a UAV that wavered goes around what is in its way, until the straight way is open."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.cost_to_go import (
    OWN_CELLS,
    RETURNS_KEEP,
    SIDE_FREE_M,
    SIDE_S,
    WAY_CELL_M,
)
from cepa.dynamic.cost_to_go.course import Course


class ChosenSide:
    """Keeps a choice until it is shown right or wrong.

    Before a wall that is longer than the window, both ends look open, and the nearer one changes while the
    UAV flies. So it keeps to one side. The straight way ahead, when it is open, shows that the side was
    right. A UAV that comes back once more has shown that it was wrong, and chooses again.
    """

    def __init__(self) -> None:
        self._direction: np.ndarray | None = None
        self._until_s = -math.inf

    @property
    def is_chosen(self) -> bool:
        """Whether a side is kept."""
        return self._direction is not None

    def choose(self, returns: int, direction: tuple[float, float] | None, stamp_s: float) -> None:
        """Keep to the side that the UAV flies to, a unit vector, if it has come back often enough."""
        if returns >= RETURNS_KEEP and direction is not None:
            self._direction, self._until_s = np.array(direction), stamp_s + SIDE_S

    def course(self, slowness: np.ndarray, course: Course, stamp_s: float) -> Course:
        """Return the course along the side, or ``course`` when the straight way is open, or its end is near.

        slowness (n, n): cost of a metre in each cell around the UAV; inf: closed.
        """
        is_over = stamp_s > self._until_s or math.isfinite(course.end[0])
        if self._direction is None or is_over or _is_open(slowness, course.direction):
            self._direction = None
            return course
        return Course(self._direction)


def _is_open(slowness: np.ndarray, direction: np.ndarray) -> bool:
    """Return whether SIDE_FREE_M along a unit vector (2,) are open, the own cells left out."""
    half = len(slowness) // 2
    steps = np.arange(OWN_CELLS + 1, min(round(SIDE_FREE_M / WAY_CELL_M), half))
    columns, rows = np.rint(steps[:, None] * direction).astype(int).T + half
    return bool(np.isfinite(slowness[rows, columns]).all())
