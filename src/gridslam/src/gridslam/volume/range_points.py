"""What range finders see beside a cloud: a level lidar sees neither what is above nor what is below it."""

from __future__ import annotations

import math
from typing import Callable

import numpy as np

from gridslam.volume.clouds import Pose

FRESH_S = 0.1
"""A range that is so much older than a cloud, or younger, does not belong to it."""


class RangePoints:
    """Keeps the newest range of each range finder, and adds it to clouds as one more point."""

    def __init__(self) -> None:
        self._newest: dict[str, tuple[float, float]] = {}

    def take(self, name: str, stamp_s: float, range_m: float, range_min_m: float, range_max_m: float) -> None:
        """Take a range; one that is no number or out of its limits says nothing. name: of its frame."""
        if math.isfinite(range_m) and range_min_m <= range_m <= range_max_m:
            self._newest[name] = stamp_s, range_m
        else:
            self._newest.pop(name, None)

    def added_to(
        self, points: np.ndarray, stamp_s: float, pose_of: Callable[[str], Pose | None]
    ) -> np.ndarray:
        """Return the points (n, 3) of a cloud, and those of the fresh ranges.

        pose_of: a range finder's pose in the cloud's frame, by its name; it looks along x. None: it is not
        known, and the range is left out.
        """
        found = []
        for name, (taken_s, range_m) in self._newest.items():
            pose = pose_of(name) if abs(stamp_s - taken_s) <= FRESH_S else None
            if pose is not None:
                found.append(pose.of_points(np.array([[range_m, 0.0, 0.0]])))
        return np.concatenate([points, *found]) if found else points
