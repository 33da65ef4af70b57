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
    below: float,
    reach: float,
    cell: float,
    lowest: np.ndarray,
) -> None:
    """Fill ``lowest`` (n * n, 3) with the lowest of ``points`` (m, 3) in each cell of a plan; inf: none.

    points: from ``origin``, along the axes in which the cells are fixed; the grid repeats itself. heights:
    only points between these count, m. below: nor do those of a cell with a point so little lower. It holds
    what reaches on down. reach: and no farther to each side.
    """
    n = int(math.sqrt(lowest.shape[0]) + 0.5)
    lowest[:] = math.inf
    for k in range(points.shape[0]):
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        if not heights[0] - below < z < heights[1] or abs(x) >= reach or abs(y) >= reach:
            continue
        column = math.floor((x + origin[0]) / cell) % n
        row = math.floor((y + origin[1]) / cell) % n
        if z + origin[2] < lowest[row * n + column, 2]:
            lowest[row * n + column, 0] = x + origin[0]
            lowest[row * n + column, 1] = y + origin[1]
            lowest[row * n + column, 2] = z + origin[2]
    for k in range(lowest.shape[0]):
        if lowest[k, 2] <= heights[0] + origin[2]:
            lowest[k] = math.inf


@njit(cache=True)
def fall_rates(times: np.ndarray, heights: np.ndarray, slopes: np.ndarray, residuals: np.ndarray) -> None:
    """Fit a line through each column of ``heights`` (n, k), m, over ``times`` (n,), s.

    Fill ``slopes`` (k,), m/s, and ``residuals`` (k,), m, the root of the mean square. Both are NaN
    where a height is not finite.
    """
    n, middle_s = times.size, times.mean()
    spread = 0.0
    for i in range(n):
        spread += (times[i] - middle_s) ** 2
    for k in range(heights.shape[1]):
        total, slope, square = 0.0, 0.0, 0.0
        for i in range(n):
            total += heights[i, k]
        middle_m = total / n  # not finite if one of them is not
        for i in range(n):
            slope += (times[i] - middle_s) * (heights[i, k] - middle_m)
        slope = slope / spread if spread > 0.0 else math.nan
        for i in range(n):
            square += (heights[i, k] - middle_m - slope * (times[i] - middle_s)) ** 2
        slopes[k], residuals[k] = slope, math.sqrt(square / n)
