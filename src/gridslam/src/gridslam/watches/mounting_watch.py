"""Finds a lidar whose scans are mirrored: it hangs upside down, and TF does not tell."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.errors import MountingError
from gridslam.filter.step_check import Link
from gridslam.scan import PlanarScan
from gridslam.watches.kept_scan import KeptScan

TURN_MIN_RAD, TURN_MAX_RAD, WAY_MAX_M = 0.25, 1.2, 1.0
"""Two scans are compared if odometry has turned and moved by so much between them."""
AGREES_SHARE, AGREES_M = 0.3, 0.3
"""A comparison agrees with odometry up to this share of the turn, and this distance."""
VOTES = 3
"""So many turns decide."""
UNDECIDED_MAX = 30
"""After so many turns that fit both ways, or neither, the watch ends: the place is its own mirror image."""


class MountingWatch:
    """Aligns scans before and after the first turns, as they are and mirrored, and compares with odometry.

    In the scans of a lidar that is upside down, walls turn the wrong way. Each turn that only the mirrored
    scans explain is a vote. The watch ends with the first few votes, so it costs nothing later.
    """

    def __init__(self) -> None:
        self._before = KeptScan()
        self._mirrored = self._proper = self._undecided = 0

    def check(self, scan: PlanarScan, base_in_odom: Sequence[float]) -> None:
        """Take in a levelled scan with the base in odom, x, y in m and yaw in rad.

        Raises:
            MountingError: the lidar is upside down.
        """
        if self._mirrored >= VOTES:
            raise MountingError(
                "The scans turn the other way than odometry: the lidar hangs upside down and TF does not "
                "tell (turn its mounting by 180 degrees of roll), or odometry's yaw has the wrong sign."
            )
        if self._proper >= VOTES or self._undecided >= UNDECIDED_MAX:
            return
        compared = self._before.step_to(scan, base_in_odom)
        if compared is None:
            return
        before, step = compared
        way_m, turn_rad = math.hypot(step[0], step[1]), abs(step[2])
        if way_m < WAY_MAX_M and turn_rad < TURN_MIN_RAD:
            return
        self._before.keep(scan, base_in_odom)
        if way_m < WAY_MAX_M and turn_rad < TURN_MAX_RAD:
            self._vote(before, scan, step)

    def _vote(self, before: PlanarScan, scan: PlanarScan, step: np.ndarray) -> None:
        is_proper = _explains(before, scan, step)
        is_mirrored = _explains(_mirror(before), _mirror(scan), step)
        if is_proper == is_mirrored:
            self._undecided += 1
        elif is_proper:
            self._proper, self._mirrored = self._proper + 1, 0
        else:
            self._mirrored, self._proper = self._mirrored + 1, 0


def _mirror(scan: PlanarScan) -> PlanarScan:
    return replace(scan, angles_rad=-scan.angles_rad)


def _explains(before: PlanarScan, scan: PlanarScan, step: np.ndarray) -> bool:
    """Whether two scans, aligned with each other, show the step that odometry tells."""
    link = Link.between(before, scan, step[None])
    if link is None:
        return False
    x, y, yaw = se2.between(step, link.pose)
    return math.hypot(x, y) < AGREES_M and abs(yaw) < AGREES_SHARE * abs(step[2])
