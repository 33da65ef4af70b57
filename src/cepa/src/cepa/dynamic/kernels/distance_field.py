"""Distance fields in the plane around the UAV."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit


@njit(cache=True)
def fill_distances(
    points: np.ndarray, x: float, y: float, field: np.ndarray, cell: float, far: float
) -> None:
    """Fill ``field`` (n, n) with the distance in m to the nearest of ``points`` (m, 2), at most ``far``.

    The points are relative to (x, y), m from the grid's middle, and lie anywhere; rows are y, columns x.
    """
    n = field.shape[0]
    half = 0.5 * (n - 1)
    reach = math.ceil(far / cell)
    field[:] = far * far
    dx2 = np.empty(2 * reach + 2)
    for k in range(points.shape[0]):
        column, row = (points[k, 0] + x) / cell + half, (points[k, 1] + y) / cell + half
        first_row, last_row = max(0, int(row) - reach), min(n - 1, int(row) + 1 + reach)
        first_column, last_column = max(0, int(column) - reach), min(n - 1, int(column) + 1 + reach)
        width = last_column - first_column + 1
        for j in range(width):
            dx2[j] = ((first_column + j - column) * cell) ** 2
        for i in range(first_row, last_row + 1):
            dy2 = ((i - row) * cell) ** 2
            cells = field[i, first_column : last_column + 1]
            for j in range(width):  # without a branch, so that several cells go at once
                d2 = dx2[j] + dy2
                cells[j] = d2 if d2 < cells[j] else cells[j]
    for i in range(n):
        for j in range(n):
            field[i, j] = math.sqrt(field[i, j])


@njit(cache=True)
def widest(finer: np.ndarray, field: np.ndarray) -> None:
    """Fill ``field`` (n, n) with the greatest of each four values of ``finer`` (2 n, 2 n)."""
    for i in range(field.shape[0]):
        for j in range(field.shape[1]):
            a, b = finer[2 * i, 2 * j], finer[2 * i, 2 * j + 1]
            c, d = finer[2 * i + 1, 2 * j], finer[2 * i + 1, 2 * j + 1]
            field[i, j] = max(max(a, b), max(c, d))
