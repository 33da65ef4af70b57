"""How the map of planes leans, by the IMU's roll and pitch over some seconds.

The map begins with the attitude that the IMU tells on the ground. An accelerometer's bias leans it by some
milliradians until the UAV has turned, and every surface of the map leans with it. A map that leans by 5 mrad
puts the floor of a hall 0.1 m too low at 20 m.
"""

from __future__ import annotations

import math

import numpy as np

from gridslam.cloud_odometry.matching import PoseInSpace
from gridslam.cloud_odometry.rotations import matrix_of, vector_of

UPRIGHT = np.array((1.0, 1.0, 0.0))
"""Only roll and pitch are corrected."""


class Levelling:
    """Turns poses in the map of planes into poses in a level frame.

    Args:
        time_s: the IMU's roll and pitch count by their mean over so long.
    """

    def __init__(self, time_s: float) -> None:
        self._time_s = time_s
        self._pivot = np.zeros(3)
        self._turn = np.zeros(3)
        self.rotation = np.eye(3)
        """(3, 3) from the map of planes to the level frame."""

    def begin(self, place: np.ndarray) -> None:
        """The map begins at a place (3,), m, which stays where it is when the lean is corrected."""
        self._pivot = place

    def learn(self, by_imu: np.ndarray, matched: np.ndarray, dt_s: float) -> None:
        """Take an attitude (3, 3) in the level frame by the IMU, and the same in the map by a match."""
        off = vector_of(by_imu @ (self.rotation @ matched).T)
        self._turn = self._turn + (1.0 - math.exp(-dt_s / self._time_s)) * UPRIGHT * off
        self.rotation = matrix_of(self._turn)

    def levelled(self, pose: PoseInSpace) -> PoseInSpace:
        """Return a pose of the map in the level frame."""
        return PoseInSpace(
            self._pivot + self.rotation @ (pose.place - self._pivot), self.rotation @ pose.rotation
        )

    def rise_m(self, place: np.ndarray) -> float:
        """Return how much higher a place (3,) of the map is in the level frame."""
        return float((self._pivot + self.rotation @ (place - self._pivot) - place)[2])
