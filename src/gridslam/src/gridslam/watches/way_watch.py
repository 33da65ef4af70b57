"""Finds scans that move to another side than odometry, or another distance.

Then the lidar is turned about the vertical, and TF does not tell, or odometry's metre is wrong.
"""

from __future__ import annotations

import cmath
import math
from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.errors import MountingError
from gridslam.filter.step_check import Link
from gridslam.scan import PlanarScan
from gridslam.watches.kept_scan import KeptScan

WAY_MIN_M, WAY_MAX_M, TURN_MAX_RAD = 0.5, 1.0, 0.1
"""Two scans are compared if odometry has moved by so much between them, and turned by less."""
AGREES_SHARE, SIGMA_MAX = 0.2, 0.15
"""A comparison agrees up to this share of the way, if its standard deviation is below this share of it."""
OTHERS = [
    *np.exp(1j * np.radians(np.arange(30.0, 331.0, 30.0))),
    *np.array((0.35, 0.5, 0.7, 1.4, 2.0, 2.8), complex),
]
"""Where odometry's way x + iy does not fit, it is turned or stretched by each of these factors."""
OFF_MIN_RAD, LONGER_MIN = 0.4, 1.5
"""Ways are other ones if they differ by this angle, or are so many times as long, or as short. Less tells
nothing: wheels slip, too.
"""
SHORTER_MAX = 4.0
"""Scans that hardly move tell of wheels that turn on the spot, not of a wrong metre."""
VOTES = 5
"""So many comparisons in a row refuse a lidar; fewer in order are enough to trust it."""
TRUSTED = 3
APART_SHARE = 0.3
"""Comparisons may differ from their mean by this share of it: the lidar has one mounting."""
UNDECIDED_MAX = 30
"""After so many comparisons that tell nothing, as in a bare corridor, the watch ends."""


class WayWatch:
    """Aligns scans before and after the first straight ways, and compares where they move with odometry.

    Where the mounting's yaw is wrong, scans move to another side, always by the same angle. Where odometry's
    metre is wrong, they move farther, or less, always by the same share. The watch ends with the first few
    ways in order, so it costs nothing later.
    """

    def __init__(self) -> None:
        self._before = KeptScan()
        self._votes: list[complex] = []
        """By what odometry's way must be turned and stretched, in the last comparisons in a row."""
        self._in_order = self._undecided = 0

    def check(self, scan: PlanarScan, base_in_odom: Sequence[float]) -> None:
        """Take in a levelled scan with the base in odom, x, y in m and yaw in rad.

        Raises:
            MountingError: the lidar is turned, or odometry's metre is wrong.
        """
        if len(self._votes) >= VOTES:
            raise MountingError(_sentence(complex(np.mean(self._votes))))
        if self._in_order >= TRUSTED or self._undecided >= UNDECIDED_MAX:
            return
        compared = self._before.step_to(scan, base_in_odom)
        if compared is None:
            return
        before, step = compared
        way_m, turn_rad = math.hypot(step[0], step[1]), abs(step[2])
        if way_m < WAY_MIN_M and turn_rad < TURN_MAX_RAD:
            return
        self._before.keep(scan, base_in_odom)
        if WAY_MIN_M <= way_m < WAY_MAX_M and turn_rad < TURN_MAX_RAD:
            self._vote(before, scan, step)

    def _vote(self, before: PlanarScan, scan: PlanarScan, step: np.ndarray) -> None:
        moved = _moved(before, scan, step, 1.0)
        if moved is not None and abs(moved - 1.0) < AGREES_SHARE:
            self._in_order, self._votes = self._in_order + 1, []
            return
        tried = [(other, _moved(before, scan, step, other)) for other in OTHERS]
        others = [found for start, found in tried if found is not None and _is_near(found, start)]
        if not others or not _are_one(others) or not _is_other(complex(np.mean(others))):
            self._undecided += 1
            return
        self._votes.append(complex(np.mean(others)))
        if not _are_one(self._votes):
            self._votes = self._votes[-1:]


def _moved(before: PlanarScan, scan: PlanarScan, step: np.ndarray, start: complex) -> complex | None:
    """Return by what odometry's step (3,) must be turned and stretched, if two scans tell it well.

    They are aligned from a step on that is turned and stretched by ``start``. A turn that differs from
    odometry's by TURN_MAX_RAD is a wrong match.
    """
    way = complex(step[0], step[1])
    begun = way * start
    link = Link.between(before, scan, np.array([[begun.real, begun.imag, step[2]]]))
    if link is None or abs(se2.wrap(link.pose[2] - step[2])) > TURN_MAX_RAD:
        return None
    sigma_m = math.sqrt(float(np.linalg.eigvalsh(link.covariance[:2, :2])[-1]))
    return None if sigma_m > SIGMA_MAX * abs(way) else complex(link.pose[0], link.pose[1]) / way


def _is_near(found: complex, start: complex) -> bool:
    """Whether scans are aligned near to where this began: not at another thing that looks alike."""
    return abs(found - start) < 0.5 * abs(start)


def _is_other(ratio: complex) -> bool:
    is_turned = abs(cmath.phase(ratio)) > OFF_MIN_RAD
    length = abs(ratio)
    is_one_length = abs(length - 1.0) < AGREES_SHARE
    is_longer = length > LONGER_MIN or 1.0 / SHORTER_MAX < length < 1.0 / LONGER_MIN
    return is_one_length if is_turned else is_longer


def _are_one(ratios: Sequence[complex]) -> bool:
    mean = complex(np.mean(ratios))
    return all(abs(ratio - mean) < APART_SHARE * abs(mean) for ratio in ratios)


def _sentence(ratio: complex) -> str:
    off_deg = math.degrees(cmath.phase(ratio))
    if abs(off_deg) < math.degrees(OFF_MIN_RAD):
        return (
            f"The scans move {abs(ratio):.2f} times as far as odometry: the metre of odometry, or of the "
            "ranges, is wrong; check the wheels' radius, and the units."
        )
    side, change = ("left", "less") if off_deg > 0.0 else ("right", "more")
    much = f"{abs(off_deg):.0f} degrees"
    return (
        f"The scans move {much} farther to the {side} than odometry: the yaw of the lidar's mounting in TF "
        f"is wrong by so much (it should be {much} {change}), or odometry's axes, or its yaw, are."
    )
