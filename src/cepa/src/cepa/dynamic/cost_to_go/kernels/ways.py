"""The shortest way down the cost-to-go, and the cross-section of the pocket behind."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit


@njit(cache=True)
def shortest_way(length: np.ndarray, column: int, row: int, cells: np.ndarray) -> int:
    """Fill ``cells`` (m, 2: column, row) with the shortest way from the middle; return their number.

    length (n, n): what `sweep` fills. column, row: of the middle among all cells of the plane.
    """
    half = length.shape[0] // 2
    i = j = half
    for count in range(cells.shape[0]):
        cells[count, 0], cells[count, 1] = column + j - half, row + i - half
        best_i, best_j, steepest = i, j, 0.0
        for k in range(max(0, i - 1), min(length.shape[0], i + 2)):
            for m in range(max(0, j - 1), min(length.shape[0], j + 2)):
                if (k != i or m != j) and (length[i, j] - length[k, m]) / math.hypot(k - i, m - j) > steepest:
                    steepest = (length[i, j] - length[k, m]) / math.hypot(k - i, m - j)
                    best_i, best_j = k, m
        if best_i == i and best_j == j:
            return count + 1
        i, j = best_i, best_j
    return cells.shape[0]


@njit(cache=True)
def cross_section(
    length: np.ndarray, slowness: np.ndarray, from_m: float, to_m: float, cells: np.ndarray
) -> int:
    """Fill ``cells`` (m, 2: column, row from the middle) with the cross-section of the pocket behind; count.

    length, slowness (n, n): what `sweep` fills and takes. The pocket is all that joins the middle by cells
    from which the way out is longer than from there. The cross-section is where it is longer by ``from_m`` to
    ``to_m``. Return 0 if the pocket reaches the edge, where nobody knows whether it goes on, or if there are
    more cells than fit.
    """
    n = length.shape[0]
    half = n // 2
    here = length[half, half]
    known = np.zeros((n, n), np.bool_)
    waiting = np.empty((n * n, 2), np.int64)
    waiting[0, 0], waiting[0, 1] = half, half
    known[half, half] = True
    end, count = 1, 0
    k = 0
    while k < end:
        i, j = waiting[k]
        k += 1
        if i == 0 or j == 0 or i == n - 1 or j == n - 1:
            return 0
        if here + from_m <= length[i, j] < here + to_m:
            if count == cells.shape[0]:
                return 0
            cells[count, 0], cells[count, 1] = j - half, i - half
            count += 1
        for a, b in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
            if not known[a, b] and not math.isinf(slowness[a, b]) and length[a, b] > here:
                known[a, b] = True
                waiting[end, 0], waiting[end, 1] = a, b
                end += 1
    return count
