"""The particles: where each is, its weight, how well its path explains all scans, and that path."""

from __future__ import annotations

import numpy as np

from gridslam import se2
from gridslam.filter import resampling
from gridslam.trajectory import Trajectory, TrajectoryTree


class Particles:
    """Hypotheses of the path. All begin at one pose (3,): x, y in m and yaw in rad.

    Args:
        pose: of all, in the map.
        count: number of particles.
        smoothing: log-weights are divided by this.
    """

    def __init__(self, pose: np.ndarray, count: int, smoothing: float) -> None:
        self._smoothing = smoothing
        self.poses = np.tile(pose, (count, 1))
        """(particles, 3) in the map, at the last processed scan."""
        self.log_weights = np.zeros(count)
        """(particles,) since the last resampling."""
        self.log_likelihoods = np.zeros(count)
        """(particles,) of each particle's whole path, by scans and odometry."""
        self.tree = TrajectoryTree(count)

    def __len__(self) -> int:
        return len(self.poses)

    @property
    def best(self) -> int:
        """The particle whose whole path explains scans and odometry best."""
        return int(np.argmax(self.log_likelihoods))

    @property
    def nodes(self) -> int:
        """Number of poses of a path."""
        return len(self.tree.stamps_s)

    def weights(self) -> np.ndarray:
        """Return the weights (particles,) since the last resampling; their sum is one."""
        return resampling.normalised(self.log_weights, 1.0 / self._smoothing)

    def weigh(self, by_scan: np.ndarray, by_odometry: np.ndarray) -> None:
        """Take in what a scan and odometry say of each particle: log-likelihoods (particles,)."""
        self.log_weights += by_scan
        self.log_likelihoods += by_scan
        self.log_likelihoods += self._smoothing * by_odometry

    def move(self, poses: np.ndarray) -> None:
        """Put the particles at these poses (particles, 3)."""
        self.poses = poses
        self.poses[:, 2] = se2.wrap(self.poses[:, 2])

    def resample(self, parents: np.ndarray) -> None:
        """Make particle i a copy of particle parents[i]."""
        self.poses = self.poses[parents]
        self.log_likelihoods = self.log_likelihoods[parents]
        self.log_weights[:] = 0.0
        self.tree.resample(parents)

    def place(self, poses: np.ndarray) -> None:
        """Put the particles, which have one path, elsewhere (particles, 3). None is the best one then."""
        self.move(poses)
        self.log_likelihoods[:] = 0.0

    def adopt(self, path: np.ndarray, now: np.ndarray) -> None:
        """Give all particles one path (k, 3), and the pose (3,) at the last processed scan."""
        self.tree.replace(path)
        self.poses = np.tile(now, (len(self.poses), 1))
        self.log_weights[:] = 0.0
        self.log_likelihoods[:] = 0.0

    def trajectory(self) -> Trajectory:
        """Return the best particle's path, at the processed scans."""
        return Trajectory(np.array(self.tree.stamps_s), self.tree.path(self.best))
