"""What the state rests on: the newest scan that saw something, and odometry since then.

Without sight odometry alone tells the way, and errs the more the longer that way is. So the state ends by how
far odometry may have erred since, or when nothing was seen for so long that nobody knows whether it is true.
"""

from __future__ import annotations

import math

import numpy as np

from gridslam import se2
from gridslam.filter.motion_model import Motion
from gridslam.inputs.continuous_odometry import DETOUR_M
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan
from gridslam.tracking.evidence import COMPARED_MIN
from gridslam.tracking.self_check import UNCERTAIN_FROM_M


def sees(scan: PlanarScan) -> bool:
    """Return whether so many beams met something that a scan can be compared with a map."""
    return int(np.count_nonzero(scan.ranges_m <= scan.range_max_m)) >= COMPARED_MIN


class Sight:
    """Age of the newest scan that saw something.

    Args:
        parameters: of the filter, whose motion model says how far odometry errs.
    """

    def __init__(self, parameters: SlamParameters) -> None:
        self._parameters = parameters
        self._since: Motion | None = None
        self._now_s = math.nan

    def see(self, stamp_s: float, base: np.ndarray, covariance: np.ndarray | None = None) -> None:
        """Take in a scan that saw something, at odometry's pose (3,) of the base, with its covariance."""
        self._since, self._now_s = Motion(base, stamp_s, covariance), stamp_s

    def follow(self, stamp_s: float, base: np.ndarray | None, covariance: np.ndarray | None = None) -> None:
        """Take in that time has passed without sight. base: see `see`; None: nobody knows it."""
        if self._since is None:
            return
        self._now_s = max(self._now_s, stamp_s)
        if base is not None:
            self._since.add(base, self._parameters, covariance)

    @property
    def age_s(self) -> float:
        """Age of the newest scan that saw something; 0 before the first one."""
        return 0.0 if self._since is None else self._now_s - self._since.stamp_s

    @property
    def deviations(self) -> np.ndarray:
        """(3,) by which odometry may have erred since then: m, m, rad."""
        return np.zeros(3) if self._since is None else self._since.deviations.copy()

    @property
    def off_m(self) -> float:
        """How far the place may be off by it; the heading's error turns the straight way since then."""
        if self._since is None:
            return 0.0
        x_m, y_m, turn_rad = self._since.deviations.tolist()
        away_m = math.hypot(*se2.between(self._since.start, self._since.now)[:2])
        return math.hypot(max(x_m, y_m), turn_rad * away_m)

    @property
    def is_poor(self) -> bool:
        """Whether odometry may have erred by more than a state that is tracking allows."""
        return self.off_m > UNCERTAIN_FROM_M

    @property
    def is_lost(self) -> bool:
        """Whether it may have erred by more than particles find again, so that a search must."""
        return self.off_m > DETOUR_M

    @property
    def reason(self) -> str:
        """What the state lacks, in words."""
        return (
            f"no scan has seen anything for {self.age_s:.0f} s; odometry alone tells the way since then, and "
            f"may have erred by {self.off_m:.1f} m"
        )
