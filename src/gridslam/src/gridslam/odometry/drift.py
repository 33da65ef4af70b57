"""How uncertain the place of the local map in `odom` has become: the error that odometry piles up."""

from __future__ import annotations

import numpy as np

from gridslam.odometry.matching import ScanMatch


class Drift:
    """The covariance (3, 3) of x, y in m and yaw in rad at the base, without that against the local map.

    It never shrinks. An error of the heading becomes one of the place with the way flown.

    References: Smith, Self and Cheeseman 1990 for compounding; REP-105 for a pose in `odom` that drifts.
    """

    def __init__(self) -> None:
        self.covariance = np.zeros((3, 3))

    def on_move(self, moved_xy: np.ndarray) -> None:
        """Take along the heading's error over a move (2,) in `odom`, m."""
        turned = np.eye(3)
        turned[0, 2], turned[1, 2] = -moved_xy[1], moved_xy[0]
        self.covariance = turned @ self.covariance @ turned.T

    def on_match(self, untold: np.ndarray, before: np.ndarray, after: np.ndarray) -> None:
        """Keep the uncertainty of directions that a scan tells, but the one before it did not.

        The scan may see surfaces that came into the local map meanwhile, at an uncertain place.

        Args:
            untold: (k, 2) directions that the scan before did not tell.
            before: (3, 3) the pose's covariance against the local map, before the match.
            after: (3, 3) the same after it.
        """
        share = np.zeros((3, 3))
        share[:2, :2] = untold.T @ untold
        share[2, 2] = float(len(untold) == 2)
        self.covariance = self.covariance + share @ (before - after) @ share

    def on_keyframe(self, match: ScanMatch, covariance: np.ndarray) -> None:
        """Take a scan that enters the local map, where M keyframes have seen its surfaces.

        It moves their mean by 1/M of its own error. A direction that it does not tell counts in `on_match`.

        Args:
            match: of the scan.
            covariance: (3, 3) of its pose against the local map.
        """
        told = np.eye(3)
        told[:2, :2] -= match.untold.T @ match.untold
        self.covariance = self.covariance + match.newness**2 * told @ covariance @ told
