"""Many readings at one exact far value: so drivers tell beams that met nothing.

REP-117 asks for +inf there. The drivers of Stage, Gazebo and CARMEN tell range_max instead, others a value
close to it, or one of their own. Real surfaces give no such value: a wall has one nearest point, and what
lies beside it is farther away. So the sign is a value that many beams share exactly, scan after scan, and
that nothing exceeds. A driver that tells +inf, or a range beyond range_max, has its word for nothing already.
"""

from __future__ import annotations

import math
from typing import Callable

import numpy as np

EXACT = 1e-6
"""Relative: two readings are equal, as far as 32-bit coordinates tell. Noise-free beams of 0.25 degrees at a
flat wall differ by more."""
MANY = 20
"""Readings at the value, in all scans that differ. A noise-free lidar in the middle of a box has 8 in one."""
FEW = 5
"""A scan with fewer at a value below range_max does not count: readings in whole cm repeat by chance."""
CLOSE = 0.02
"""Relative: if more readings lie so close below the value, it is the upper end of a wall's noise."""
NEAR, SCANS = 0.95, 10
"""From this share of range_max on, one scan may decide. A value below must come in so many scans that differ,
because a lidar that rests in the middle of a round tank sees one range, too."""
AGAINST = 0.1
"""So many readings beyond the value for each one at it, and it is a real range after all."""
KEPT = 100 * MANY
"""So many readings at the value count at most, so that a mistake does not last."""
GREATEST_M = float(np.finfo(np.float32).max)
"""Of a range. What is greater is +inf."""
BACK_S = 1.0
"""A stamp that is older by more: the clock was set back."""


class FarValue:
    """The value by which one lidar tells that a beam met nothing, if it has one.

    The decision rests on all scans so far, so one of them close to a wall does not change it.
    """

    def __init__(self) -> None:
        self._stamp_s = -math.inf
        self._forget(math.inf)

    def _forget(self, greatest_m: float) -> None:
        self._greatest_m, self._unreturned = greatest_m, 0
        self._watch(0.0)

    def _watch(self, value_m: float) -> None:
        self._value_m = value_m
        self._at = self._beyond = self._scans = 0
        self._rest_m = math.nan

    @property
    def value_m(self) -> float | None:
        """The value, m; None: no far value stands for nothing."""
        against = self._beyond + self._unreturned
        is_told = self._at >= MANY and (self._value_m >= NEAR * self._greatest_m or self._scans >= SCANS)
        return self._value_m if is_told and against <= AGAINST * self._at else None

    def rewind(self) -> None:
        """Take in the same scans once more, from the first."""
        self._stamp_s = -math.inf

    def learn(self, stamp_s: float, ranges_m: np.ndarray, limits_m: tuple[float, float]) -> None:
        """Take in a scan's ranges (n,), m, by REP-117. limits_m: range_min and range_max."""
        least_m, greatest_m = limits_m
        if stamp_s < self._stamp_s - BACK_S or greatest_m != self._greatest_m:
            self._forget(greatest_m)
        self._stamp_s = stamp_s
        limit_m = min(greatest_m * (1.0 + EXACT), GREATEST_M)
        top_m, unreturned = float(np.fmax.reduce(ranges_m, initial=0.0)), 0
        if top_m > limit_m:
            unreturned = int(np.count_nonzero(ranges_m > limit_m))
            self._unreturned += unreturned
            if self._unreturned > AGAINST * KEPT:
                return  # it has another word for nothing, for good
            top_m = float(ranges_m[ranges_m <= limit_m].max(initial=0.0))
        if top_m <= least_m:
            return
        at = _count_from(ranges_m, top_m * (1.0 - EXACT)) - unreturned
        if top_m > self._value_m * (1.0 + EXACT):
            self._beyond += _count_from(ranges_m, self._value_m * (1.0 + EXACT)) - unreturned
            if self._beyond > AGAINST * self._at:
                self._watch(top_m)
        elif top_m < self._value_m * (1.0 - EXACT) and self._at < MANY <= at:
            self._watch(top_m)  # the greater one was a stray
        if abs(top_m - self._value_m) <= EXACT * top_m:
            self._count(ranges_m, at)

    def _count(self, ranges_m: np.ndarray, at: int) -> None:
        """Count a scan that has readings at the value, unless it is the one before once more."""
        if self._at >= KEPT and self._scans >= SCANS:
            return
        if at < FEW and self._value_m < self._greatest_m * (1.0 - EXACT):
            return
        nearer_m = ranges_m[(ranges_m > 0.0) & (ranges_m < self._value_m * (1.0 - EXACT))]
        if at < np.count_nonzero(nearer_m > (1.0 - CLOSE) * self._value_m):
            return
        rest_m = float(nearer_m.sum(dtype=np.float64))
        if rest_m != self._rest_m:
            self._at, self._scans, self._rest_m = min(self._at + at, KEPT), self._scans + 1, rest_m


def _count_from(ranges_m: np.ndarray, least_m: float) -> int:
    return int(np.count_nonzero(ranges_m >= least_m))


class FarValues:
    """The far values of all lidars that a node hears, by their frames.

    Args:
        say: is called with a sentence when a value is taken for nothing, or no longer.
    """

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._of: dict[str, FarValue] = {}

    def rewind(self) -> None:
        """Take in the same scans once more, from the first."""
        for far in self._of.values():
            far.rewind()

    def nothing_in(
        self, frame: str, stamp_s: float, ranges_m: np.ndarray, limits_m: tuple[float, float]
    ) -> tuple[np.ndarray, float] | None:
        """Return which of a scan's ranges (n,), m, met nothing, and the value that tells it; None: none."""
        far = self._of.setdefault(frame, FarValue())
        before_m = far.value_m
        far.learn(stamp_s, ranges_m, limits_m)
        value_m = far.value_m
        if value_m != before_m:
            self._tell(frame, value_m, before_m, limits_m[1])
        if value_m is None:
            return None
        met_nothing = (ranges_m >= value_m * (1.0 - EXACT)) & (ranges_m <= value_m * (1.0 + EXACT))
        return (met_nothing, value_m) if met_nothing.any() else None

    def _tell(self, frame: str, value_m: float | None, before_m: float | None, greatest_m: float) -> None:
        if value_m is None:
            self._say(f'"{frame}" tells more than {before_m:.6g} m now, so that range is real again.')
            return
        limit = f" (its range_max is {greatest_m:.6g} m)" if math.isfinite(greatest_m) else ""
        self._say(
            f'Many beams of "{frame}" tell exactly {value_m:.6g} m{limit} and none tells more: these are '
            "taken for beams that met nothing, for which REP-117 asks the driver to tell +inf."
        )
