"""Tells a single pose that is wild from a jump that lasts, such as SLAM's correction after a loop closure."""

from __future__ import annotations

import math

import numpy as np

MOST_JUMP_M, MOST_SPEED = 2.0, 30.0
"""A pose may be so far from the one before, and so many metres more for each second between them."""
LASTING = 3
"""So many poses in a row that agree with each other are believed, wherever they are."""

StampedPlace = tuple[float, np.ndarray]


class PoseJumps:
    """Watches the places of one UAV, also where the clock jumps back.

    Attributes:
        off_m: how far the last pose was from the one that is believed.
    """

    def __init__(self) -> None:
        self._believed: StampedPlace | None = None
        self._doubted: list[StampedPlace] = []
        self.off_m = 0.0

    def is_wild(self, stamp_s: float, place_m: np.ndarray) -> bool:
        """Take a pose (x, y, z). Return whether to leave it out: no UAV can have come there."""
        now = stamp_s, place_m
        self.off_m = 0.0 if self._believed is None else math.dist(self._believed[1], place_m)
        if self._believed is not None and not _follows(self._believed, now):
            if self._doubted and not _follows(self._doubted[-1], now):
                self._doubted = []
            self._doubted.append(now)
            if len(self._doubted) < LASTING:
                return True
        self._believed, self._doubted = now, []
        return False


def _follows(before: StampedPlace, now: StampedPlace) -> bool:
    """Return whether a UAV may come from one place to the other."""
    since_s = max(now[0] - before[0], 0.0)
    return math.dist(before[1], now[1]) <= MOST_JUMP_M + MOST_SPEED * since_s
