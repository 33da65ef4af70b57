"""Finds odometry that turns fast while the scans hardly turn, again and again: its yaw is in degrees."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.errors import MountingError
from gridslam.filter.step_check import Link
from gridslam.scan import PlanarScan
from gridslam.watches.kept_scan import KeptScan

TURN_MIN_RAD, PERIOD_MAX_S = 0.1, 1.0
"""Two scans are compared as soon as odometry has turned by so much between them, if that took no longer."""
FAST_RAD, FAST_RAD_S = 0.3, 2.0
"""Between two scans in a row wheels that slip turn by less than the first, or slower than the second."""
GUESSES_RAD = np.array((-0.3, -0.15, 0.0, 0.15, 0.3))
"""Scans are aligned beginning at odometry's step, and at each of these turns."""
AGREES_SHARE, AGREES_RAD = 0.3, 0.1
"""A comparison agrees with odometry up to this share of the turn, and this angle: chance rarely does."""
TURNS_SHARE = 1.0 / 3.0
"""It contradicts odometry if the scans turn by less than this share of the turn that odometry tells."""
VOTES, TRUSTED = 5, 3
"""So many contradictions in a row refuse odometry. Fewer agreements in all are enough to trust it."""


class YawWatch:
    """Aligns scans between which odometry turns, and compares how they turn, until it is trusted.

    A yaw of degrees that is taken for radians turns 57 times as far as the vehicle, and begins anew with
    each turn of it. What odometry tells looks like chance, then. Wheels that slip do not turn so fast.
    """

    def __init__(self) -> None:
        self._before = KeptScan()
        self._last: tuple[float, float] | None = None
        """Stamp, s, and yaw of odometry, rad, of the last scan."""
        self._votes: list[tuple[float, float]] = []
        """Turns of odometry and of the scans, rad, in the last contradictions in a row."""
        self._in_order = 0

    def check(self, scan: PlanarScan, base_in_odom: Sequence[float]) -> None:
        """Take in a levelled scan with the base in odom, x, y in m and yaw in rad.

        Raises:
            MountingError: odometry's yaw cannot be in radians.
        """
        if len(self._votes) >= VOTES:
            raise MountingError(_sentence(np.array(self._votes)))
        if self._in_order >= TRUSTED:
            return
        is_fast = self._is_fast(scan.stamp_s, float(base_in_odom[2]))
        self._last = scan.stamp_s, float(base_in_odom[2])
        compared = self._before.step_to(scan, base_in_odom)
        if compared is None:
            return
        before, step = compared
        period_s = scan.stamp_s - before.stamp_s
        if abs(step[2]) < TURN_MIN_RAD and 0.0 <= period_s <= PERIOD_MAX_S:
            return
        self._before.keep(scan, base_in_odom)
        if abs(step[2]) >= TURN_MIN_RAD and 0.0 < period_s <= PERIOD_MAX_S:
            self._vote(before, scan, step, is_fast)

    def _is_fast(self, stamp_s: float, yaw_rad: float) -> bool:
        if self._last is None:
            return False
        turn_rad = abs(float(se2.wrap(yaw_rad - self._last[1])))
        return turn_rad > max(FAST_RAD, FAST_RAD_S * (stamp_s - self._last[0]))

    def _vote(self, before: PlanarScan, scan: PlanarScan, step: np.ndarray, is_fast: bool) -> None:
        guesses = np.zeros((1 + len(GUESSES_RAD), 3))
        guesses[0], guesses[1:, 2] = step, GUESSES_RAD
        link = Link.between(before, scan, guesses)
        if link is None:
            return
        told_rad, turn_rad = float(step[2]), float(link.pose[2])
        if abs(se2.wrap(turn_rad - told_rad)) < min(AGREES_SHARE * abs(told_rad), AGREES_RAD):
            self._in_order, self._votes = self._in_order + 1, []
        elif is_fast and abs(turn_rad) < TURNS_SHARE * abs(told_rad):
            self._votes.append((told_rad, turn_rad))


def _sentence(votes: np.ndarray) -> str:
    told_rad, turned_rad = np.median(np.abs(votes), axis=0)
    return (
        f"Odometry turns by {told_rad:.2f} rad between scans that turn by {turned_rad:.2f} rad, again and "
        "again: its yaw is wrong; check whether it is in radians, not in degrees, where TF's quaternion is "
        "made of it."
    )
