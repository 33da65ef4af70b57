"""gmapping's odometry motion model: the uncertainty of the true motion, given odometry.

gmapping draws new noise at every scan. So a lidar with four times the rate halves the uncertainty of the same
path. Here the deviations of all steps add up, so a path is as uncertain as one step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gridslam import se2
from gridslam.parameters import SlamParameters

SIDEWAYS = 0.3
"""gmapping's share of srr with which a translation to one side makes the other uncertain."""
DEVIATION_MIN = (1e-4, 1e-4, 1e-5)
"""m, m, rad: no motion is known better than this."""


class Motion:
    """The odometry since the last processed scan, and its uncertainty."""

    def __init__(self, base_in_odom: np.ndarray, stamp_s: float):
        self.start = np.array(base_in_odom, float)
        self.now = self.start
        self.stamp_s = stamp_s
        self.distance_m = 0.0
        self.turned_rad = 0.0
        self.deviations = np.zeros(3)
        """Standard deviations of x, y in m and yaw in rad, in the base frame: the sum over all steps."""
        self.tried = np.array((0.0, 0.0, stamp_s))
        """Travel in m, turning in rad and stamp in s at which a scan was last processed, or refused."""
        self.due = False
        """Whether the next scan is to be processed, whatever the motion."""

    def add(self, base_in_odom: np.ndarray, parameters: SlamParameters) -> None:
        """Take the next odometry pose."""
        step = np.abs(se2.between(self.now, base_in_odom))
        self.distance_m += math.hypot(step[0], step[1])
        self.turned_rad += step[2]
        self.deviations += _deviations(step[0], step[1], step[2], parameters)
        self.now = np.array(base_in_odom, float)

    @property
    def step(self) -> np.ndarray:
        """(3,) the present pose in the frame of the start."""
        return se2.between(self.start, self.now)

    @property
    def deviation(self) -> np.ndarray:
        """(3,) standard deviation of the step, never quite 0."""
        return np.maximum(self.deviations, DEVIATION_MIN)

    def is_enough(self, parameters: SlamParameters, stamp_s: float) -> bool:
        """Whether a scan at this time is worth processing."""
        travelled_m, turned_rad, tried_s = self.tried.tolist()
        return (
            self.due
            or self.distance_m - travelled_m >= parameters.linearUpdate
            or self.turned_rad - turned_rad >= parameters.angularUpdate
            or (parameters.temporalUpdate >= 0.0 and stamp_s - tried_s > parameters.temporalUpdate)
        )

    def refuse(self, stamp_s: float) -> None:
        """Note that the scan at this time was refused: the next one comes after as much motion again."""
        self.tried, self.due = np.array((self.distance_m, self.turned_rad, stamp_s)), False


@dataclass(frozen=True, eq=False)
class Prediction:
    """The particles' poses by odometry alone, in the map frame."""

    predicted: np.ndarray
    """(particles, 3) by odometry without noise."""
    drawn: np.ndarray
    """(particles, 3) drawn from the motion model."""
    information: np.ndarray
    """(particles, 3, 3) inverse covariance of the motion model around ``predicted``, in 1/m2 and 1/rad2."""

    def log_density(self, poses: np.ndarray) -> np.ndarray:
        """Return the log-density (particles,) of poses (particles, 3) by odometry; 0 at ``predicted``."""
        errors = poses - self.predicted
        errors[:, 2] = se2.wrap(errors[:, 2])
        return -0.5 * np.einsum("pi,pij,pj->p", errors, self.information, errors)


def predict(poses: np.ndarray, motion: Motion, rng: np.random.Generator) -> Prediction:
    """Move particles (particles, 3) as odometry did, with and without noise."""
    step, deviation = motion.step, motion.deviation
    noise = deviation * rng.standard_normal(poses.shape)
    return Prediction(
        se2.compose(poses, step), se2.compose(poses, step + noise), _information(poses, deviation)
    )


def _deviations(x: float, y: float, yaw: float, parameters: SlamParameters) -> np.ndarray:
    """Return gmapping's deviations (3,) of a small step's x, y and yaw from its sizes."""
    return np.array(
        (
            parameters.srr * (x + SIDEWAYS * y) + parameters.str * yaw,
            parameters.srr * (y + SIDEWAYS * x) + parameters.str * yaw,
            parameters.stt * yaw + parameters.srt * math.hypot(x, y),
        )
    )


def _information(poses: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Return a motion's information (particles, 3, 3) in the map frame, for particles that start at poses."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    turn = np.zeros((len(poses), 3, 3))
    turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1] = cos, -sin, sin, cos
    turn[:, 2, 2] = 1.0
    return (turn / deviation**2) @ turn.transpose(0, 2, 1)
