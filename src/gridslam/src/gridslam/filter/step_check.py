"""Finds steps of the filter that both odometry and the scan before contradict.

Where a scan shows little of the map, the filter may match it far off. Most wrong matches are found out here:
the scan is also aligned with the last one that was processed. If this link says the same as odometry, and not
what the filter's step says, the step is wrong.
"""

from __future__ import annotations

import numpy as np

from gridslam import se2
from gridslam.filter.motion_model import Motion, Prediction, predict
from gridslam.kernels.links import measure_pairs
from gridslam.maps.scan_surfaces import ScanSurfaces, surfaces_of
from gridslam.scan import PlanarScan
from gridslam.tracking.wrong_steps import MATCH_SIGMA, apart, are_wrong

RANGE_M, GATE_M, SHARE_MIN, RMS_MAX_M = 30.0, 0.3, 0.5, 0.1
"""Of a link: range of beams, distance of points that are a pair, least share of points with a pair, and
greatest root mean square of the pairs' distances.
"""
POINTS_MOST, POINT_SIGMA_M = 12.0, 0.03


class StepCheck:
    """Keeps the last processed scan."""

    def __init__(self) -> None:
        self._before: PlanarScan | None = None

    def remember(self, scan: PlanarScan | None) -> None:
        """Note the scan that the next step begins at; None: the next step cannot be checked."""
        self._before = scan

    @property
    def before(self) -> PlanarScan | None:
        """The scan at which the next step begins."""
        return self._before

    def wrong(self, scan: PlanarScan, step: np.ndarray, motion: Motion) -> Link | None:
        """Return the link that says what a step (3,) was really, if the step is wrong."""
        odometry = motion.step
        if self._before is None or apart(odometry[None], step[None])[0] < 1.0:
            return None
        link = Link.between(self._before, scan, np.stack([step, odometry]))
        return link if link is not None and link.contradicts(step, odometry) else None


class Link:
    """The pose (3,) of a scan relative to another one, measured by aligning both, and its covariance."""

    def __init__(self, pose: np.ndarray, covariance: np.ndarray) -> None:
        self.pose, self.covariance = pose, covariance

    @classmethod
    def between(cls, before: PlanarScan, scan: PlanarScan, predicted: np.ndarray) -> Link | None:
        """Align two scans, beginning at each of the predicted poses (k, 3); None: too few points fit."""
        scans = ScanSurfaces(surfaces_of(each, RANGE_M) for each in (before, scan))
        poses, covariances, are_found = (
            np.array(predicted, float)[None],
            np.empty((1, 3, 3)),
            np.zeros(1, bool),
        )
        measure_pairs(
            scans.arrays,
            np.array([[0, 1]]),
            poses,
            1,
            (0.0, GATE_M),
            SHARE_MIN,
            RMS_MAX_M,
            POINTS_MOST,
            POINT_SIGMA_M,
            covariances,
            are_found,
        )
        if not are_found[0]:
            return None
        pose = poses[0, 0].copy()
        pose[2] = se2.wrap(pose[2])
        return cls(pose, covariances[0] + np.diag(MATCH_SIGMA**2))

    def contradicts(self, step: np.ndarray, odometry: np.ndarray) -> bool:
        """Return whether a step is far from this link, and odometry near."""
        return bool(are_wrong(step[None], odometry[None], self.pose[None], self.covariance[None])[0])

    def predict(self, poses: np.ndarray, best: int, rng: np.random.Generator) -> Prediction:
        """Move particles (particles, 3) as the link says, with noise and without, the best one without."""
        motion = Motion(np.zeros(3), 0.0)
        motion.now, motion.deviations = self.pose, np.sqrt(np.diag(self.covariance))
        return predict(poses, motion, best, rng)
