"""The lowest points over the UAV in the cells of a plan."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit


@njit(cache=True)
def lowest_over(
    points: np.ndarray,
    origin: tuple[float, float, float],
    heights: tuple[float, float],
    reach: float,
    cell: float,
    lowest: np.ndarray,
) -> None:
    """Fill ``lowest`` (n * n, 3) with the lowest of ``points`` (m, 3) in each cell of a plan; inf: none.

    points: from ``origin``, along the axes in which the cells are fixed; the grid repeats itself. heights:
    only points between these count, m. reach: and no farther to each side.
    """
    n = int(math.sqrt(lowest.shape[0]) + 0.5)
    lowest[:] = math.inf
    for k in range(points.shape[0]):
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        if not heights[0] < z < heights[1] or abs(x) >= reach or abs(y) >= reach:
            continue
        column = math.floor((x + origin[0]) / cell) % n
        row = math.floor((y + origin[1]) / cell) % n
        if z + origin[2] < lowest[row * n + column, 2]:
            lowest[row * n + column, 0] = x + origin[0]
            lowest[row * n + column, 1] = y + origin[1]
            lowest[row * n + column, 2] = z + origin[2]
