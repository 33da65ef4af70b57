"""Where the body would be in cells that were not seen free."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.kernels.distance_layers import band_of
from kernel_cache.compiler import njit


@njit(cache=True)
def unseen_layers(
    stamps: np.ndarray,
    origin: np.ndarray,
    oldest: float,
    cell: np.ndarray,
    layer_m: float,
    body: np.ndarray,
    heights: np.ndarray,
    unseen: np.ndarray,
    first: int,
    last: int,
) -> None:
    """Fill ``unseen`` (layers, k, k): whether a body there would be in cells not seen since ``oldest`` (s).

    stamps (n, n, levels), origin, cell: as for ``clouds.stamp_seen``. body: radius, and ends below and above
    its origin, m. heights: lowest and highest z allowed in the odometry's frame; beyond it all is unseen.
    first, last: only these rows and columns (``last`` not among them) are filled.
    """
    layers, side, _ = unseen.shape
    first, last, most = max(0, first), min(side, last), int(body[0] / cell[0])
    n, levels = stamps.shape[0], stamps.shape[2]
    first_z = math.floor(origin[2] / cell[1]) - levels // 2
    columns = np.empty((side, side), np.uint64)
    for i in range(max(0, first - most), min(side, last + most)):
        row = math.floor((origin[1] + (i - side // 2) * cell[0]) / cell[0]) % n
        for j in range(max(0, first - most), min(side, last + most)):
            column = stamps[row, math.floor((origin[0] + (j - side // 2) * cell[0]) / cell[0]) % n]
            mask, level = np.uint64(0), first_z % levels
            for k in range(levels):
                if column[level] < oldest:
                    mask |= np.uint64(1) << np.uint64(k)
                level = level + 1 if level + 1 < levels else 0
            columns[i, j] = mask
    dilated = _dilated(columns, body[0] / cell[0], first, last)
    lowest = first_z * cell[1] - origin[2]
    for layer in range(layers):
        height = (layer - layers // 2) * layer_m
        allowed = heights[0] <= origin[2] + height <= heights[1]
        band = band_of(lowest, height - body[1], height + body[2], cell[1])
        for i in range(first, last):
            for j in range(first, last):
                unseen[layer, i, j] = not allowed or (dilated[i, j] & band) != 0


@njit(cache=True)
def _dilated(columns: np.ndarray, radius: float, first: int, last: int) -> np.ndarray:
    """Return ``columns`` (k, k), each with the bits of all that are at most ``radius`` cells away.

    Only the rows and columns from ``first`` to before ``last`` are filled.
    """
    side = columns.shape[0]
    most = int(radius)
    dilated = np.empty_like(columns)
    for i in range(first, last):
        for j in range(first, last):
            mask = np.uint64(0)
            for di in range(-most, most + 1):
                for dj in range(-most, most + 1):
                    inside = 0 <= i + di < side and 0 <= j + dj < side
                    if inside and di * di + dj * dj <= radius * radius:
                        mask |= columns[i + di, j + dj]
            dilated[i, j] = mask
    return dilated
