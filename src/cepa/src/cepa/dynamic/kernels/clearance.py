"""How near a place is to what stands and to what moves."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.kernels.response import State
from kernel_cache.compiler import njit


@njit(cache=True, inline="always")
def interpolated(grid: np.ndarray, layer: int, cell: float, x: float, y: float, outside: float) -> float:
    """Return the value of a grid's layer at (x, y) m from its middle, between its four nearest cells."""
    half = 0.5 * (grid.shape[1] - 1)
    column, row = x / cell + half, y / cell + half
    j, i = math.floor(column), math.floor(row)
    if i < 0 or j < 0 or i >= grid.shape[1] - 1 or j >= grid.shape[1] - 1:
        return outside
    s, t = column - j, row - i
    return (1.0 - t) * ((1.0 - s) * grid[layer, i, j] + s * grid[layer, i, j + 1]) + t * (
        (1.0 - s) * grid[layer, i + 1, j] + s * grid[layer, i + 1, j + 1]
    )


@njit(cache=True, inline="always")
def layer_at(count: int, layer_m: float, z: float) -> int:
    """Return the layer at height z, or -1 beyond the layers; a single layer has no height."""
    if count == 1:
        return 0
    layer = math.floor(z / layer_m + 0.5) + count // 2
    return layer if 0 <= layer < count else -1


@njit(cache=True, inline="always")
def clearance_of_standing(
    distance: np.ndarray, cell_m: float, layer_m: float, far: float, state: State
) -> float:
    """Return the distance to the nearest of what stands, m."""
    layer = layer_at(distance.shape[0], layer_m, state[2][0])
    return interpolated(distance, layer, cell_m, state[0][0], state[1][0], far) if layer >= 0 else 0.0


@njit(cache=True, inline="always")
def clearance_as_known(
    distance: np.ndarray, cell_m: float, layer_m: float, far: float, state: State
) -> float:
    """Return the same, but beyond the layers that of the outermost one: nothing else is known there."""
    count = distance.shape[0]
    layer = 0
    if count > 1:
        layer = min(max(math.floor(state[2][0] / layer_m + 0.5) + count // 2, 0), count - 1)
    return interpolated(distance, layer, cell_m, state[0][0], state[1][0], far)


@njit(cache=True, inline="always")
def clearance_of_moving(movers: np.ndarray, state: State, t: float) -> float:
    """Return the distance to the nearest of what moves, m, after t s."""
    x, y = state[0][0], state[1][0]
    d = math.inf
    for k in range(movers.shape[0]):
        dx, dy = x - movers[k, 0] - movers[k, 2] * t, y - movers[k, 1] - movers[k, 3] * t
        d = min(d, math.sqrt(dx * dx + dy * dy) - movers[k, 4] - movers[k, 5] * t)
    return d
