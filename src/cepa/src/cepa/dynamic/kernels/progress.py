"""The cost-to-go and its slope at a place."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.kernels.clearance import interpolated
from kernel_cache.compiler import njit


@njit(cache=True)
def cost_to_go_at(way: np.ndarray, cell_m: float, x: float, y: float, direction: np.ndarray) -> float:
    """Return the length of the shortest way out from (x, y), m; outside of the window along ``direction``."""
    half = 0.5 * (way.shape[1] - 1) * cell_m
    farthest = max(abs(x), abs(y))
    scale = min(1.0, 0.999 * half / farthest) if farthest > 0.0 else 1.0
    beyond = (1.0 - scale) * (x * direction[0] + y * direction[1])
    return interpolated(way, 0, cell_m, scale * x, scale * y, math.inf) - beyond


@njit(cache=True, inline="always")
def slope_at(
    way: np.ndarray, cell_m: float, x: float, y: float, direction: np.ndarray
) -> tuple[float, float]:
    """Return how much longer the way out is two cells farther along x and along y, m."""
    h = cell_m
    half = 0.5 * (way.shape[1] - 1)
    column, row = x / h + half, y / h + half
    j, i = math.floor(column), math.floor(row)
    if min(i, j) < 1 or max(i, j) > way.shape[1] - 3:
        along_x = cost_to_go_at(way, h, x + h, y, direction) - cost_to_go_at(way, h, x - h, y, direction)
        return along_x, cost_to_go_at(way, h, x, y + h, direction) - cost_to_go_at(
            way, h, x, y - h, direction
        )
    s, t = column - j, row - i
    low_x = (1.0 - s) * (way[0, i, j + 1] - way[0, i, j - 1]) + s * (way[0, i, j + 2] - way[0, i, j])
    high_x = (1.0 - s) * (way[0, i + 1, j + 1] - way[0, i + 1, j - 1]) + s * (
        way[0, i + 1, j + 2] - way[0, i + 1, j]
    )
    low_y = (1.0 - t) * (way[0, i + 1, j] - way[0, i - 1, j]) + t * (way[0, i + 2, j] - way[0, i, j])
    high_y = (1.0 - t) * (way[0, i + 1, j + 1] - way[0, i - 1, j + 1]) + t * (
        way[0, i + 2, j + 1] - way[0, i, j + 1]
    )
    return (1.0 - t) * low_x + t * high_x, (1.0 - s) * low_y + s * high_y
