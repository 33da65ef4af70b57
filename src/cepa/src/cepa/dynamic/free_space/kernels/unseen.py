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
            at = first_z % levels  # the lowest level
            above, below = _older(column[at:], oldest), _older(column[:at], oldest)
            columns[i, j] = above | (below << np.uint64(levels - at))
    dilated = _dilated(columns, body[0] / cell[0], first, last)
    lowest = first_z * cell[1] - origin[2]
    for layer in range(layers):
        height = (layer - layers // 2) * layer_m
        allowed = heights[0] <= origin[2] + height <= heights[1]
        band = band_of(lowest, height - body[1], height + body[2], cell[1])
        for i in range(first, last):
            row, masks = unseen[layer, i, first:last], dilated[i, first:last]
            for j in range(row.size):
                row[j] = not allowed or (masks[j] & band) != 0


@njit(cache=True)
def _older(stamps: np.ndarray, oldest: float) -> np.uint64:
    """Return which ``stamps`` (n,) are older, as bits."""
    mask = np.uint64(0)
    for k in range(stamps.size):  # without a branch, so that several go at once
        mask |= np.uint64(stamps[k] < oldest) << np.uint64(k)
    return mask


@njit(cache=True)
def _dilated(columns: np.ndarray, radius: float, first: int, last: int) -> np.ndarray:
    """Return ``columns`` (k, k), each with the bits of all that are at most ``radius`` cells away.

    Only the rows and columns from ``first`` to before ``last`` are filled.
    """
    side, most = columns.shape[0], int(radius)
    dilated = np.zeros_like(columns)
    for i in range(first, last):
        for di in range(max(-most, -i), min(most, side - 1 - i) + 1):
            for dj in range(-most, most + 1):
                if di * di + dj * dj > radius * radius:
                    continue
                begin, end = max(first, -dj), min(last, side - dj)
                masks, beside = dilated[i, begin:end], columns[i + di, begin + dj : end + dj]
                for j in range(masks.size):
                    masks[j] |= beside[j]
    return dilated
