"""A Kalman filter of place, heading, velocity and the accelerometer's bias, in the plane.

The IMU predicts from scan to scan; a matched scan corrects. State: x, y, yaw in the odometry's frame,
velocity x, y in that frame, bias x, y in the levelled base frame.
"""

from __future__ import annotations

import math

import numpy as np

from gridslam.odometry.inertial import Motion
from gridslam.odometry.matching import ScanMatch
from gridslam.odometry.parameters import LidarOdometryParameters
from gridslam.se2 import wrap

POSE, PLACE, SPEED, BIAS = slice(0, 3), slice(0, 2), slice(3, 5), slice(5, 7)
FIRST_SIGMAS = (1e-3, 1e-3, 1e-3, 0.05, 0.05, 0.1, 0.1)
BIAS_MAX = 0.5
TURN_UNKNOWN = 5.0
"""rad/s/sqrt(s): white noise of the turn's acceleration if the IMU tells no turn."""


class PlanarFilter:
    """The state (7,) and its covariance (7, 7)."""

    def __init__(self, parameters: LidarOdometryParameters, pose: np.ndarray) -> None:
        self._p = parameters
        self.state = np.concatenate((pose, np.zeros(4)))
        self.covariance = np.diag(np.square(FIRST_SIGMAS))

    def predict(self, dt_s: float, motion: Motion, untold: np.ndarray, is_turn_guessed: bool = False) -> None:
        """Move on by dt_s. Along the directions in ``untold`` (k, 2) the speed decays.

        is_turn_guessed: no gyroscope tells the turn.
        """
        state, p = self.state, self._p
        yaw = state[2] + 0.5 * motion.turn_rad
        cos, sin = math.cos(yaw), math.sin(yaw)
        axes = np.array(((cos, -sin), (sin, cos)))
        model = np.eye(7)
        model[PLACE, SPEED] = dt_s * np.eye(2)
        acceleration, density = np.zeros(2), p.acceleration_unknown
        if motion.acceleration_xy is not None:
            felt = motion.acceleration_xy - state[BIAS]
            acceleration, density = axes @ felt, p.acceleration_noise
            model[PLACE, BIAS], model[SPEED, BIAS] = -0.5 * dt_s**2 * axes, -dt_s * axes
            turned = np.array((-acceleration[1], acceleration[0]))
            model[PLACE, 2], model[SPEED, 2] = 0.5 * dt_s**2 * turned, dt_s * turned
        state[PLACE] += dt_s * state[SPEED] + 0.5 * dt_s**2 * acceleration
        state[SPEED] += dt_s * acceleration
        state[2] = wrap(state[2] + motion.turn_rad)
        self.covariance = model @ self.covariance @ model.T + self._noise(dt_s, density)
        if is_turn_guessed:
            self.covariance[2, 2] += TURN_UNKNOWN**2 * dt_s**3 / 3.0
        decay = np.eye(2) - (1.0 - math.exp(-dt_s / p.rest_time_s)) * untold.T @ untold
        state[SPEED] = decay @ state[SPEED]

    def _noise(self, dt_s: float, density: float) -> np.ndarray:
        p, noise = self._p, np.zeros((7, 7))
        q = density**2
        for i in (0, 1):
            noise[i, i], noise[3 + i, 3 + i] = q * dt_s**3 / 3.0, q * dt_s
            noise[i, 3 + i] = noise[3 + i, i] = q * dt_s**2 / 2.0
            noise[5 + i, 5 + i] = p.acceleration_bias**2 * dt_s
        noise[2, 2] = p.turn_noise**2 * dt_s
        return noise

    def correct(self, match: ScanMatch) -> None:
        """Take the match of a scan; ``match.pose`` already weighs the prediction."""
        before, spread = self.covariance[POSE, POSE], self.covariance[:, POSE]
        change = match.pose - self.state[POSE]
        change[2] = wrap(change[2])
        inverse = np.linalg.inv(before)
        after = np.linalg.inv(inverse + match.information)
        share = spread @ inverse
        self.state += share @ change
        self.state[2] = wrap(self.state[2])
        np.clip(self.state[BIAS], -BIAS_MAX, BIAS_MAX, out=self.state[BIAS])
        self.covariance -= share @ (before - after) @ share.T
        self.covariance = 0.5 * (self.covariance + self.covariance.T)
