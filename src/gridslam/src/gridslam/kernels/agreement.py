"""Which beams of a scan agree with the walls of a map, and which contradict them.

Everything is in cells from the corner of the particle's table and radians.
"""

from __future__ import annotations

import math

import numpy as np

from gridslam.kernels.tiles import MASK, SIDE_BITS
from kernel_cache.compiler import njit

NEAR = 2
"""Cells: a beam agrees if the map has a wall within this much of its end, along x and along y."""
AGREES, CLASHES, UNSEEN = 0, 1, 2


@njit(cache=True, nogil=True, inline="always")
def _is_wall(x: int, y: int, table: np.ndarray, occupied: np.ndarray) -> bool:
    row, column = y >> SIDE_BITS, x >> SIDE_BITS
    if not (0 <= row < table.shape[0] and 0 <= column < table.shape[1]):
        return False
    return (occupied[table[row, column], y & MASK] >> np.uint32(x & MASK)) & 1 == 1


@njit(cache=True, nogil=True)
def _is_near_wall(x: int, y: int, table: np.ndarray, occupied: np.ndarray) -> bool:
    for near_y in range(y - NEAR, y + NEAR + 1):
        for near_x in range(x - NEAR, x + NEAR + 1):
            if _is_wall(near_x, near_y, table, occupied):
                return True
    return False


@njit(cache=True, nogil=True)
def verdicts(
    pose: np.ndarray,
    lidar_xy: np.ndarray,
    ends_xy: np.ndarray,
    table: np.ndarray,
    occupied: np.ndarray,
    placed: np.ndarray,
) -> np.ndarray:
    """Return (n,) what each beam says: it agrees, it clashes with a wall, or no wall is near or before.

    ``pose`` (3,) is that of the base. ``lidar_xy`` (2,) and ``ends_xy`` (n, 2) are in its frame; all beams
    must have hit something. ``table`` and ``occupied`` are those of `Tiles`. ``placed`` (n, 2) takes where
    the beams end in the map.
    """
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    from_x = pose[0] + cos * lidar_xy[0] - sin * lidar_xy[1]
    from_y = pose[1] + sin * lidar_xy[0] + cos * lidar_xy[1]
    found = np.full(ends_xy.shape[0], UNSEEN)
    for i in range(ends_xy.shape[0]):
        to_x = pose[0] + cos * ends_xy[i, 0] - sin * ends_xy[i, 1]
        to_y = pose[1] + sin * ends_xy[i, 0] + cos * ends_xy[i, 1]
        placed[i, 0], placed[i, 1] = to_x, to_y
        if _is_near_wall(math.floor(to_x), math.floor(to_y), table, occupied):
            found[i] = AGREES
            continue
        steps = int(max(abs(to_x - from_x), abs(to_y - from_y)))
        for step in range(steps + 1):
            share = step / max(steps, 1)
            x = math.floor(from_x + share * (to_x - from_x))
            y = math.floor(from_y + share * (to_y - from_y))
            if _is_wall(x, y, table, occupied):
                found[i] = CLASHES
                break
    return found
