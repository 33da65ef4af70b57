"""Where the UAV would fit if all that is unknown were free."""

from __future__ import annotations

import math

import numpy as np
from scipy import ndimage

from inspection_tools.exploration.kernels.borders import flood
from inspection_tools.planning import OCCUPIED, UNKNOWN
from inspection_tools.planning.kernels.distances import squared_clearances
from inspection_tools.planning.space import Space


def is_near_room(space: Space, nodes: np.ndarray, least_m3: float) -> np.ndarray:
    """Return (d, h, w) which voxels are so near to unknown room for the UAV that they may open it.

    Room is what the UAV's centre could reach if all that is unknown were free. nodes: (n, 3) z, y, x, that a
    way leads to. least_m3: less room in one piece does not count.
    """
    reach = math.isqrt(space.need - 1) + 1
    fits = squared_clearances(_blocked(space), reach) >= space.need
    if math.isfinite(space.limits.ceiling_m):
        highest = math.floor(space.limits.ceiling_m / space.grid.resolution_m - 0.5)
        fits[max(highest - int(space.grid.corner[2]) + 1, 0) :] = False
    room = flood(fits, nodes) & (space.grid.kinds == UNKNOWN) & (space.squares < space.need)
    pieces, _ = ndimage.label(room, np.ones((3, 3, 3), bool))
    voxels = np.bincount(pieces.ravel())
    voxels[0] = 0
    room = (voxels * space.grid.resolution_m**3 >= max(least_m3, space.grid.resolution_m**3))[pieces]
    if not room.any():
        return room
    near: np.ndarray = squared_clearances(room, reach) < reach * reach
    return near


def _blocked(space: Space) -> np.ndarray:
    blocked: np.ndarray = space.grid.kinds == OCCUPIED
    for box in space.limits.boxes:
        corners = np.array((box.low_m, box.high_m)) / space.grid.resolution_m
        low = np.floor(corners[0]).astype(np.int64) - space.grid.corner
        high = np.ceil(corners[1]).astype(np.int64) - space.grid.corner
        low, high = np.maximum(low[::-1], 0), np.maximum(high[::-1], 0)
        blocked[tuple(map(slice, low.tolist(), high.tolist()))] = True
    return blocked
