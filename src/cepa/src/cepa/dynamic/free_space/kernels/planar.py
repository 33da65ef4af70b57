"""Cells that a planar scan and range finders show free."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.kernels.angles import bin_of
from kernel_cache.compiler import njit


@njit(cache=True)
def stamp_below_ranges(
    stamps: np.ndarray,
    cells: tuple[np.ndarray, np.ndarray, np.ndarray],
    x: np.ndarray,
    y: np.ndarray,
    z: np.ndarray,
    edges: tuple[float, float],
    free_m: np.ndarray,
    is_body: np.ndarray,
    normal: np.ndarray,
    stamp: float,
) -> None:
    """Stamp what beams have passed: the cells of the plane itself, and the body's levels above and below.

    stamps, cells, x, y, z, edges: a window of `Cells`. free_m (bins,): see `LidarPlane`. is_body (levels,):
    which levels the body is in. normal (3,): of the lidar's plane.
    """
    i, j, k = cells
    bins, levels = free_m.size, z.size
    per_rad = bins / (2.0 * math.pi)
    farthest = free_m.max()
    for row in range(y.size):
        for column in range(x.size):
            h = math.sqrt(x[column] * x[column] + y[row] * y[row]) + 0.5 * edges[0]
            if h >= farthest or not free_m[bin_of(x[column], y[row], per_rad) % bins] > h:
                continue
            seen = stamps[i[row], j[column]]
            for level in range(levels):
                if is_body[level]:
                    seen[k[level]] = stamp
            if normal[2] != 0.0:
                tilted = -(normal[0] * x[column] + normal[1] * y[row]) / normal[2]
                place = math.floor((tilted - z[0]) / edges[1] + 0.5)
                if 0 <= place < levels:
                    seen[k[place]] = stamp


@njit(cache=True)
def stamp_discs(
    stamps: np.ndarray,
    cells: tuple[np.ndarray, np.ndarray, np.ndarray],
    x: np.ndarray,
    y: np.ndarray,
    middles: np.ndarray,
    is_passed: np.ndarray,
    radius: float,
    stamp: float,
) -> None:
    """Stamp the cells within ``radius`` of ``middles`` (levels, 2), m, at the levels that are passed.

    stamps, cells, x, y: a window of `Cells`. is_passed (levels,).
    """
    i, j, k = cells
    for level in range(is_passed.size):
        if not is_passed[level]:
            continue
        for row in range(y.size):
            across = y[row] - middles[level, 1]
            if abs(across) > radius:
                continue
            for column in range(x.size):
                along = x[column] - middles[level, 0]
                if abs(along) <= radius and math.hypot(along, across) < radius:
                    stamps[i[row], j[column], k[level]] = stamp
