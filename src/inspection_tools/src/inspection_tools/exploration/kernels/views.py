"""Which cells a lidar would see from which places."""

from __future__ import annotations

import math

import numpy as np

from inspection_tools.planning.voxel_grid import FREE
from kernel_cache.compiler import njit

TOGETHER = 1e-9
"""Borders that a line crosses within this share of it are crossed at once, as at an edge or a corner."""


@njit(cache=True, nogil=True)
def is_open(kinds: np.ndarray, a: np.ndarray, b: np.ndarray) -> bool:
    """Return whether a line runs through free voxels only, between two voxels' (z, y, x) centres.

    The line is followed from voxel to voxel (Amanatides and Woo, 1987).
    """
    voxel = np.array((a[0], a[1], a[2]))
    way = np.array((b[0] - a[0], b[1] - a[1], b[2] - a[2]))
    steps = abs(way[0]) + abs(way[1]) + abs(way[2])
    next_at = np.empty(3)
    for axis in range(3):
        next_at[axis] = 0.5 / abs(way[axis]) if way[axis] != 0 else math.inf
    for _ in range(steps + 1):
        if kinds[voxel[0], voxel[1], voxel[2]] != FREE:
            return False
        border = next_at.min()
        if border > 1.0:
            break
        for axis in range(3):
            if next_at[axis] <= border + TOGETHER:
                voxel[axis] += 1 if way[axis] > 0 else -1
                next_at[axis] += 1.0 / abs(way[axis])
    return True


@njit(cache=True, nogil=True)
def seen_from(
    kinds: np.ndarray,
    places: np.ndarray,
    cells: np.ndarray,
    counts: np.ndarray,
    slopes: tuple[float, float],
    reaches: tuple[float, float],
    is_seen: np.ndarray,
) -> np.ndarray:
    """Return (n,) how many frontier voxels each place shows.

    Args:
        kinds: (d, h, w) of the map.
        places: (n, 3) z, y, x of voxels.
        cells: (m, 3) those of the cells.
        counts: (m,) frontier voxels in them.
        slopes: tangents of the lowest and the highest beam's elevation.
        reaches: least and greatest distance of a view, in voxels.
        is_seen: (m,) set where any place sees a cell.
    """
    gains = np.zeros(len(places), np.int64)
    for n in range(len(places)):
        for m in range(len(cells)):
            dz = cells[m, 0] - places[n, 0]
            level = math.hypot(cells[m, 1] - places[n, 1], cells[m, 2] - places[n, 2])
            far = math.hypot(level, dz)
            if far > reaches[1] or far < reaches[0]:
                continue
            if dz < slopes[0] * level - 0.5 or dz > slopes[1] * level + 0.5:
                continue
            if is_open(kinds, places[n], cells[m]):
                gains[n] += counts[m]
                is_seen[m] = True
    return gains
