"""The points that clouds have shown, remembered in cells; the nearest ones when there are too many."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.distance_fields import FIELD_WINDOW_M
from cepa.dynamic.constants.obstacle_tracks import STOOD_APART_M, STOOD_S, STOOD_UP_M
from cepa.dynamic.constants.remembered import (
    MOST_POINTS,
    VOXEL_HEIGHT_M,
    VOXEL_LEVELS,
    VOXEL_M,
    VOXEL_REACH_UP_M,
    VOXELS,
)
from cepa.dynamic.remembered.kernels.voxels import NOBODY, Voxels, forget_far, have_stood, recall, remember

REACH_M = np.array([0.5 * FIELD_WINDOW_M, VOXEL_REACH_UP_M])

Picture = tuple[np.ndarray, float, float, float, int]
"""The newest cloud's picture, as `recall` takes it: nearest, row_tan, gap, near, misses."""


class VoxelMemory:
    """Keeps one point in each cell, in the odometry's frame."""

    def __init__(self) -> None:
        self._voxels = Voxels(
            np.empty((MOST_POINTS, 3)),
            np.empty(MOST_POINTS),
            np.empty(MOST_POINTS),
            np.empty(MOST_POINTS, np.uint8),
            np.empty((VOXELS, VOXELS, VOXEL_LEVELS), np.int32),
            VOXEL_M,
            VOXEL_HEIGHT_M,
        )
        self._points = np.empty((MOST_POINTS, 3))
        self.reset()

    def reset(self) -> None:
        """Forget all points."""
        self._voxels.slots[:] = NOBODY
        self._known = 0
        self.kept_m: float | None = None  # what is farther was forgotten for want of room; None: nothing

    def update(
        self, returns: np.ndarray, origin: np.ndarray, stamp_s: float, oldest_s: float, picture: Picture
    ) -> tuple[np.ndarray, np.ndarray]:
        """Remember ``returns`` (n, 3), m; return all points (m, 3), m, and which of them are older (m,).

        Points are relative to ``origin``. Points older than ``oldest_s`` are forgotten, and so are those that
        clouds have seen through. The returns are always among the points, also those that find no room.
        """
        self.kept_m = None
        self._known, rest = remember(returns, origin, stamp_s, REACH_M, self._voxels, self._known)
        self._known = recall(
            origin, stamp_s, oldest_s, REACH_M, *picture, self._voxels, self._known, self._points
        )
        left = returns[rest]
        if len(left):
            left = self._remember_more(left, origin, stamp_s)
        if len(left):
            left = self._remember_nearest(left, origin, stamp_s)
        points, is_older = self._points[: self._known], self._voxels.stamps[: self._known] < stamp_s
        if len(left):
            points, is_older = np.concatenate((points, left)), np.append(is_older, np.zeros(len(left), bool))
        return points, is_older

    def forget_over(self, origin: np.ndarray, radius_m: float, way: float) -> None:
        """Forget, at the next update, what is over (way 1) or under (-1) ``origin``, m, within a radius."""
        away = self._voxels.points[: self._known] - origin
        gone = (way * away[:, 2] > 0.0) & (np.hypot(away[:, 0], away[:, 1]) < radius_m)
        self._voxels.stamps[: self._known][gone] = -math.inf

    def have_stood(self, points: np.ndarray, origin: np.ndarray, stamp_s: float) -> np.ndarray:
        """Return at which points (n, 3), m, relative to ``origin``, something has stood for long (n,)."""
        return have_stood(points, origin, stamp_s - STOOD_S, STOOD_APART_M, STOOD_UP_M, self._voxels)

    def _remember_more(self, returns: np.ndarray, origin: np.ndarray, stamp_s: float) -> np.ndarray:
        """Remember further returns of the same instant; return those that find no room."""
        before = self._known
        self._known, rest = remember(returns, origin, stamp_s, REACH_M, self._voxels, before)
        self._points[before : self._known] = self._voxels.points[before : self._known] - origin
        return returns[rest]

    def _remember_nearest(self, returns: np.ndarray, origin: np.ndarray, stamp_s: float) -> np.ndarray:
        """Remember those returns that are nearer than what is remembered, in its place; return the others."""
        near_m, all_m = _distances_m(returns), _distances_m(self._points[: self._known])
        all_m = np.append(all_m, near_m)
        self.kept_m = kept_m = float(np.partition(all_m, MOST_POINTS - 1)[MOST_POINTS - 1])
        self._known = forget_far(kept_m, self._voxels, self._known, self._points)
        is_near = near_m <= kept_m
        left = self._remember_more(returns[is_near], origin, stamp_s)
        return np.concatenate((left, returns[~is_near]))


def _distances_m(points: np.ndarray) -> np.ndarray:
    """Return the level distances (n,) of points (n, 3)."""
    return np.sqrt(points[:, 0] * points[:, 0] + points[:, 1] * points[:, 1])
