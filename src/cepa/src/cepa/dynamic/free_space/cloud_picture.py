"""The newest cloud as a picture: what is near and what is free in each direction."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.free_space import (
    COARSE_BINS,
    COARSE_ROWS,
    FEWEST_RETURNS,
    PICTURE_BINS,
    PICTURE_ROW_TAN,
    PICTURE_ROWS,
    RANGE_MARGIN_M,
)
from cepa.dynamic.free_space.kernels.clouds import free_distances, level
from cepa.motion import Cloud, Motion


class CloudPicture:
    """Takes in one cloud after the other; the next one overwrites what it shows.

    nearest (PICTURE_ROWS, PICTURE_BINS): m, to the nearest point; inf: there is none. free (COARSE_ROWS,
    COARSE_BINS): m, how far it is free.
    """

    def __init__(self) -> None:
        self.nearest = np.empty((PICTURE_ROWS, PICTURE_BINS), np.float32)
        self.free = np.empty((COARSE_ROWS, COARSE_BINS), np.float32)
        self._levelled = np.empty((0, 3))

    def take_in(self, cloud: Cloud | None, motion: Motion) -> np.ndarray:
        """Take in a cloud, or that none came; return its points (n, 3), m, along the odometry's axes."""
        if cloud is None:
            self.nearest[:] = math.inf
            self.free[:] = 0.0
            return self._levelled[:0]
        if len(self._levelled) < len(cloud.points_m):
            self._levelled = np.empty((len(cloud.points_m), 3))
        rotation, limits = motion.rotation(), (cloud.range_min_m, cloud.range_max_m)
        points = np.asarray(cloud.points_m, np.float32)
        count = level(points, rotation, *limits, PICTURE_ROW_TAN, self._levelled, self.nearest)
        no_return_m = cloud.range_max_m - RANGE_MARGIN_M if count >= FEWEST_RETURNS else 0.0
        view = cloud.elevation_rad, cloud.azimuth_rad
        free_distances(self.nearest, PICTURE_ROW_TAN, rotation, *view, no_return_m, self.free)
        return self._levelled[:count]
