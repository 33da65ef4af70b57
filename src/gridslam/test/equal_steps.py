"""A path of equal steps, and matches between its nodes."""

from __future__ import annotations

import numpy as np

from gridslam import se2
from gridslam.loop_closure.edges import Edge, Match


class Steps:
    """Equal steps with one covariance, as `MeasuredPath` has them."""

    def __init__(self, step, covariance, count):
        self.steps = np.tile(np.array(step, dtype=float), (count, 1))
        self.covariances = np.tile(covariance, (count, 1, 1))
        poses = [np.zeros(3)]
        for each in self.steps:
            poses.append(se2.compose(poses[-1], each))
        self.poses = np.array(poses)
        self.climbs_m, self.heights_m = np.zeros(count), np.zeros(count + 1)
        self.way_m = np.concatenate([[0.0], np.cumsum(np.hypot(*self.steps[:, :2].T))])

    def __len__(self):
        return len(self.poses)

    def edges(self):
        return [
            Edge(i, i + 1, step, covariance)
            for i, (step, covariance) in enumerate(zip(self.steps, self.covariances))
        ]


def match(older, newer, pose, sigma=0.02):
    return Match(older, newer, np.array(pose, dtype=float), sigma**2 * np.eye(3), 0.9)
