"""Turns velocities between the scan's frame and the odometry's axes."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np


class Heading:
    """The direction of the lidar's x axis in the odometry's plane."""

    def __init__(self, yaw_rad: float) -> None:
        self._cos, self._sin = math.cos(yaw_rad), math.sin(yaw_rad)

    def into_odometry(self, v_xy: Sequence[float], climb_m_s: float) -> np.ndarray:
        """Return a velocity of the scan's frame, m/s, along the odometry's axes (3,), with a climb."""
        rotation, in_scan, velocity = np.empty((2, 2)), np.empty(2), np.empty(3)
        rotation[0, 0] = rotation[1, 1] = self._cos
        rotation[0, 1], rotation[1, 0] = -self._sin, self._sin
        in_scan[0], in_scan[1] = v_xy
        rotation.dot(in_scan, velocity[:2])
        velocity[2] = climb_m_s
        return velocity

    def into_scan(self, x: float, y: float) -> tuple[float, float]:
        """Return a velocity along the odometry's axes, m/s, in the scan's frame."""
        c, s = self._cos, self._sin
        return c * x + s * y, -s * x + c * y
