"""The newest cloud as a picture: what is near and what is free in each direction."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.free_space import (
    COARSE_BINS,
    COARSE_ROWS,
    FEWEST_RETURNS,
    HIGH_PICTURE_ROWS,
    PICTURE_BINS,
    PICTURE_ROW_TAN,
    PICTURE_ROWS,
    RANGE_MARGIN_M,
)
from cepa.dynamic.free_space.kernels.clouds import level, open_empty
from cepa.motion import Cloud, Motion


class CloudPicture:
    """Takes in one cloud after the other; the next one overwrites what it shows.

    nearest (rows, PICTURE_BINS): m, to the nearest point; inf: there is none. free (coarse rows,
    COARSE_BINS): m, how far it is free. There are more rows for a lidar that looks steeply up or down.
    """

    def __init__(self) -> None:
        self._resize(PICTURE_ROWS)
        self._levelled = np.empty((0, 3))

    def _resize(self, rows: int) -> None:
        self.nearest = np.empty((rows, PICTURE_BINS), np.float32)
        self.free = np.empty((rows * COARSE_ROWS // PICTURE_ROWS, COARSE_BINS), np.float32)

    @property
    def rows_in_one(self) -> int:
        """How many rows of `nearest` are one of `free`."""
        return len(self.nearest) // len(self.free)

    def take_in(self, cloud: Cloud | None, motion: Motion) -> np.ndarray:
        """Take in a cloud, or that none came; return its points (n, 3), m, along the odometry's axes."""
        if cloud is None:
            self.nearest[:] = math.inf
            self.free[:] = 0.0
            return self._levelled[:0]
        steepest_tan = math.tan(max(map(abs, cloud.elevation_rad)))
        is_steep = steepest_tan > 0.5 * PICTURE_ROWS * PICTURE_ROW_TAN
        if is_steep and len(self.nearest) < HIGH_PICTURE_ROWS:
            self._resize(HIGH_PICTURE_ROWS)
        if len(self._levelled) < len(cloud.points_m):
            self._levelled = np.empty((len(cloud.points_m), 3))
        rotation, limits = motion.rotation(), (cloud.range_min_m, cloud.range_max_m)
        points = np.asarray(cloud.points_m, np.float32)
        count = level(points, rotation, *limits, PICTURE_ROW_TAN, self._levelled, self.nearest, self.free)
        no_return_m = cloud.range_max_m - RANGE_MARGIN_M if count >= FEWEST_RETURNS else 0.0
        if cloud.own_m is not None:
            self._close(cloud.own_m @ rotation.T)
        view = cloud.elevation_rad, cloud.azimuth_rad
        open_empty(self.free, self.rows_in_one, PICTURE_ROW_TAN, rotation, *view, no_return_m)
        return self._levelled[:count]

    def _close(self, own: np.ndarray) -> None:
        """Let nothing be free in the directions in which the UAV sees itself. own (n, 3): levelled, m."""
        x, y, z = own.T
        rows, bins = self.free.shape
        row = z / (np.maximum(np.hypot(x, y), 1e-3) * PICTURE_ROW_TAN * self.rows_in_one) + 0.5 * rows
        column = (np.arctan2(y, x) + math.pi) * bins / (2.0 * math.pi)
        self.free[np.clip(row, 0, rows - 1).astype(int), column.astype(int) % bins] = 0.0
