"""The cost-to-go and its slope at a place."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.kernels.clearance import interpolated
from kernel_cache.compiler import njit


@njit(cache=True)
def cost_to_go_at(length: np.ndarray, cell_m: float, x: float, y: float, direction: np.ndarray) -> float:
    """Return the length of the shortest way out from (x, y), m; outside of the window along ``direction``.

    length: see `CostToGo`.
    """
    half = 0.5 * (length.shape[1] - 1) * cell_m
    farthest = max(abs(x), abs(y))
    scale = min(1.0, 0.999 * half / farthest) if farthest > 0.0 else 1.0
    beyond = (1.0 - scale) * (x * direction[0] + y * direction[1])
    return interpolated(length, 0, cell_m, scale * x, scale * y, math.inf) - beyond


@njit(cache=True, inline="always")
def slope_at(
    length: np.ndarray, cell_m: float, x: float, y: float, direction: np.ndarray
) -> tuple[float, float]:
    """Return how much longer the way out is two cells farther along x and along y, m."""
    h = cell_m
    half = 0.5 * (length.shape[1] - 1)
    column, row = x / h + half, y / h + half
    j, i = math.floor(column), math.floor(row)
    if min(i, j) < 1 or max(i, j) > length.shape[1] - 3:
        right = cost_to_go_at(length, h, x + h, y, direction)
        left = cost_to_go_at(length, h, x - h, y, direction)
        above = cost_to_go_at(length, h, x, y + h, direction)
        below = cost_to_go_at(length, h, x, y - h, direction)
        return right - left, above - below
    s, t = column - j, row - i
    low_x = (1.0 - s) * (length[0, i, j + 1] - length[0, i, j - 1])
    low_x += s * (length[0, i, j + 2] - length[0, i, j])
    high_x = (1.0 - s) * (length[0, i + 1, j + 1] - length[0, i + 1, j - 1])
    high_x += s * (length[0, i + 1, j + 2] - length[0, i + 1, j])
    low_y = (1.0 - t) * (length[0, i + 1, j] - length[0, i - 1, j])
    low_y += t * (length[0, i + 2, j] - length[0, i, j])
    high_y = (1.0 - t) * (length[0, i + 1, j + 1] - length[0, i - 1, j + 1])
    high_y += t * (length[0, i + 2, j + 1] - length[0, i, j + 1])
    return (1.0 - t) * low_x + t * high_x, (1.0 - s) * low_y + s * high_y
