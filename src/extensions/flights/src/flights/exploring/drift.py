"""SLAM's pose drifts, and closed loops take the drift back: then the map, and the UAV in it, move at once."""

from __future__ import annotations

import bisect
from dataclasses import dataclass

import numpy as np

from gridslam.volume import Pose


@dataclass(frozen=True)
class Drift:
    """Drifts that grow evenly from one closed loop to the next.

    Attributes:
        closed_s: when loops are closed, s, rising.
        offsets: (n, 3) pose of odom in the map right before each, x, y in m, yaw in rad. After the last one
            there is no drift.

    Raises:
        ValueError: the shapes do not agree.
    """

    closed_s: tuple[float, ...]
    offsets: np.ndarray

    def __post_init__(self) -> None:
        if self.offsets.shape != (len(self.closed_s), 3):
            raise ValueError(
                f"{len(self.closed_s)} closed loops need as many offsets, not {self.offsets.shape}."
            )

    @classmethod
    def drawn(
        cls,
        rng: np.random.Generator,
        period_s: tuple[float, float],
        far_m: float,
        turn_rad: float,
        until_s: float,
    ) -> Drift:
        """Draw loops up to a time.

        period_s: bounds of the time between two. far_m, turn_rad: the greatest drift.
        """
        closed_s = np.cumsum(rng.uniform(*period_s, size=1 + int(until_s / period_s[0])))
        closed_s = closed_s[closed_s < until_s]
        course, far = rng.uniform(-np.pi, np.pi, len(closed_s)), rng.uniform(0.0, far_m, len(closed_s))
        turns = rng.uniform(-turn_rad, turn_rad, len(closed_s))
        return cls(
            tuple(closed_s.tolist()), np.stack((far * np.cos(course), far * np.sin(course), turns), axis=1)
        )

    def closed_until(self, stamp_s: float) -> int:
        """Return how many loops are closed at a time."""
        return bisect.bisect_right(self.closed_s, stamp_s)

    def odom_in_map(self, stamp_s: float) -> Pose:
        """Return the pose of odom in the map at a time."""
        number = self.closed_until(stamp_s)
        if number == len(self.closed_s):
            return Pose.identity()
        begin_s = self.closed_s[number - 1] if number else 0.0
        share = (stamp_s - begin_s) / (self.closed_s[number] - begin_s)
        return Pose.level(*(share * self.offsets[number]).tolist())
