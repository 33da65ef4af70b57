"""Notices odometry whose position, or yaw, has never changed, while the scans tell that it should."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from gridslam import se2
from gridslam.filter.step_check import Link
from gridslam.localisation.standstill import STILL_M, STILL_RAD
from gridslam.scan import PlanarScan

PERIOD_MIN_S, PERIOD_MAX_S = 0.2, 1.5
"""Two scans in a row that are aligned are so far apart."""
WAY_MIN_M, TURN_MIN_RAD = 0.3, 0.2
"""Scans tell a way, or a turn, from this on. Half of it is none."""
WAY_TURN_MAX_RAD = 0.3
"""A way is told by scans between which odometry turns by less, as a lidar beside the axis moves in turns."""
WAYS_M = 0.3 * np.array([(x, y) for x in (-2, -1, 0, 1, 2) for y in (-1, 0, 1)], float)
TURNS_RAD = np.array((-0.6, -0.3, 0.0, 0.3, 0.6))
"""Scans are aligned beginning at where the last one was found, and this farther on."""
AGREES_RAD = 0.1
"""Where a way is told, scans turn as odometry does, up to this."""
SIGMA_MAX = 0.15
"""A way or a turn counts if its standard deviation is below this share of it, unlike along a corridor."""
VOTES, VOTES_SHARE = 3, 0.01
"""So many ways or turns decide, if they are this share of the comparisons, too."""


class Begin(NamedTuple):
    """The scan that others are compared with."""

    scan: PlanarScan
    base: np.ndarray
    """(3,) in odom."""
    last: np.ndarray
    """(3,) Where the last scan was found, relative to it."""
    last_base: np.ndarray
    """(3,) The base in odom at the last scan."""
    last_s: float


class StillPart:
    """Aligns scans with each other as long as odometry's position, or its yaw, has never changed.

    A way, or a turn, counts if the scans tell it well, and do not fit where odometry puts them. So a vehicle
    that turns on the spot, or that never turns, and a bare corridor are no matter.
    """

    def __init__(self) -> None:
        self.has_moved = self.has_turned = False
        """Whether odometry's position has ever changed, and its yaw."""
        self._first: np.ndarray | None = None
        self._begin: Begin | None = None
        self._compared = self._votes = 0

    def add(self, scan: PlanarScan, base_in_odom: Sequence[float]) -> None:
        """Take in a levelled scan with the base in odom, x, y in m and yaw in rad."""
        if self.has_moved and self.has_turned:
            return
        base = np.asarray(base_in_odom, dtype=np.float64)
        self._first = base if self._first is None else self._first
        x, y, yaw = se2.between(self._first, base)
        self.has_moved = self.has_moved or math.hypot(x, y) > STILL_M
        self.has_turned = self.has_turned or abs(yaw) > STILL_RAD
        begin = self._begin
        if begin is None or not 0.0 <= scan.stamp_s - begin.last_s <= PERIOD_MAX_S:
            self._begin_at(scan, base)
        elif scan.stamp_s - begin.last_s >= PERIOD_MIN_S and self.has_moved != self.has_turned:
            self._compare(begin, scan, base)

    @property
    def is_wrong(self) -> bool:
        """Whether the part that has never changed should have."""
        is_one = self.has_moved != self.has_turned
        return is_one and self._votes >= max(VOTES, VOTES_SHARE * self._compared)

    def _begin_at(self, scan: PlanarScan, base: np.ndarray) -> None:
        self._begin = Begin(scan, base, np.zeros(3), base, scan.stamp_s)

    def _compare(self, begin: Begin, scan: PlanarScan, base: np.ndarray) -> None:
        told = se2.between(begin.base, base)
        link = Link.between(begin.scan, scan, self._guesses(begin, base, told))
        self._compared += 1
        if link is None or (self.has_turned and abs(told[2]) > WAY_TURN_MAX_RAD):
            self._begin_at(scan, base)
        elif self._reach(link.pose) < 1.0:
            self._begin = begin._replace(last=link.pose, last_base=base, last_s=scan.stamp_s)
        else:
            self._votes += self._is_clear(link, told) and not self._fits(begin.scan, scan, told)
            self._begin_at(scan, base)

    def _guesses(self, begin: Begin, base: np.ndarray, told: np.ndarray) -> np.ndarray:
        if self.has_turned:
            ways = begin.last[:2] + WAYS_M
            return np.column_stack([ways, np.full(len(ways), told[2])])
        way_m = float(np.hypot(*(base - begin.last_base)[:2]))
        steps = [(way_m * ahead, 0.0, turn) for ahead in (0.0, 1.0) for turn in TURNS_RAD]
        return np.stack([told, *(se2.compose(begin.last, np.array(step)) for step in steps)])

    def _reach(self, pose: np.ndarray) -> float:
        """Return how far a pose is, of what counts as a way, or a turn."""
        if self.has_turned:
            return float(np.hypot(pose[0], pose[1])) / WAY_MIN_M
        return abs(float(pose[2])) / TURN_MIN_RAD

    def _is_clear(self, link: Link, told: np.ndarray) -> bool:
        x, y, yaw = link.pose
        if not self.has_turned:
            return math.sqrt(float(link.covariance[2, 2])) < SIGMA_MAX * abs(yaw)
        sigma_m = math.sqrt(float(np.linalg.eigvalsh(link.covariance[:2, :2])[-1]))
        return abs(se2.wrap(yaw - told[2])) < AGREES_RAD and sigma_m < SIGMA_MAX * math.hypot(x, y)

    def _fits(self, before: PlanarScan, scan: PlanarScan, told: np.ndarray) -> bool:
        """Whether the scans fit where odometry puts them, too."""
        link = Link.between(before, scan, told[None])
        return link is not None and self._reach(link.pose) < 0.5
