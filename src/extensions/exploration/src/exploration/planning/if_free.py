"""Clearances if all that is unknown were free: to what is known to be in the way."""

from __future__ import annotations

import math

import numpy as np

from exploration.planning.kernels.distances import squared_clearances
from exploration.planning.space import Space
from exploration.planning.voxel_grid import OCCUPIED


def clearances_if_free(space: Space, reach: int) -> np.ndarray:
    """Return (d, h, w) squared clearances, at most reach**2 voxels, if all that is unknown were free.

    0: above the ceiling.
    """
    squares: np.ndarray = squared_clearances(_blocked(space), reach)
    if math.isfinite(space.limits.ceiling_m):
        highest = math.floor(space.limits.ceiling_m / space.grid.resolution_m - 0.5)
        squares[max(highest - int(space.grid.corner[2]) + 1, 0) :] = 0
    return squares


def _blocked(space: Space) -> np.ndarray:
    blocked: np.ndarray = space.grid.kinds == OCCUPIED
    for box in space.limits.boxes:
        corners = np.array((box.low_m, box.high_m)) / space.grid.resolution_m
        low = np.floor(corners[0]).astype(np.int64) - space.grid.corner
        high = np.ceil(corners[1]).astype(np.int64) - space.grid.corner
        low, high = np.maximum(low[::-1], 0), np.maximum(high[::-1], 0)
        blocked[tuple(map(slice, low.tolist(), high.tolist()))] = True
    return blocked
