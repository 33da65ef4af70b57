"""The cost-to-go by fast sweeping of the eikonal equation (Zhao 2005)."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.cost_to_go import END_REACH_M, EXIT_COST
from kernel_cache.compiler import njit


@njit(cache=True)
def _godunov(length: np.ndarray, slowness: float, cell: float, i: int, j: int) -> float:
    n = length.shape[0]
    a = min(length[i - 1, j] if i > 0 else math.inf, length[i + 1, j] if i < n - 1 else math.inf)
    b = min(length[i, j - 1] if j > 0 else math.inf, length[i, j + 1] if j < n - 1 else math.inf)
    low, high = (a, b) if a < b else (b, a)
    step = slowness * cell
    if high - low >= step:
        return low + step
    return 0.5 * (low + high + math.sqrt(2.0 * step * step - (high - low) ** 2))


@njit(cache=True)
def _begin_at(
    end: np.ndarray, slowness: np.ndarray, cell: float, length: np.ndarray, waits: np.ndarray
) -> None:
    """Begin the ways at the open cells nearest to ``end`` (2,), if any is within END_REACH_M of it."""
    n = length.shape[0]
    middle, reach = n // 2, math.ceil(END_REACH_M / cell)
    column, row = middle + round(end[0] / cell), middle + round(end[1] / cell)
    low_i, high_i, low_j, high_j = row - reach, row + reach + 1, column - reach, column + reach + 1
    nearest = END_REACH_M
    for begins in range(2):
        for i in range(max(0, low_i), min(n, high_i)):
            for j in range(max(0, low_j), min(n, high_j)):
                if math.isinf(slowness[i, j]):
                    continue
                away = math.hypot((j - middle) * cell - end[0], (i - middle) * cell - end[1])
                if begins and away <= nearest + cell:
                    length[i, j] = min(length[i, j], away)
                    waits[max(0, i - 1) : i + 2, max(0, j - 1) : j + 2] = True
                elif not begins:
                    nearest = min(nearest, away)


@njit(cache=True)
def sweep(
    slowness: np.ndarray, cell: float, direction: np.ndarray, end: np.ndarray, length: np.ndarray, rounds: int
) -> None:
    """Fill ``length`` (n, n) with the length of the shortest way out of the window towards ``direction``, m.

    slowness (n, n): cost of a metre; inf where the UAV does not fit. The way ends on the window's edge. What
    then left to fly along ``direction`` is added, times EXIT_COST, because nobody knows what stands there.
    end (2,): m, from the middle; inf: there is none. The way leads to the open cells that are nearest to it.
    The method is fast sweeping (Zhao 2005) of the eikonal equation, which leaves out the cells that have no
    neighbour with a new, shorter way (Bak, McLaughlin and Renzi 2010).
    """
    n = length.shape[0]
    waits = np.zeros((n, n), np.bool_)
    half = 0.5 * (n - 1) * cell
    length[:] = math.inf
    reach = half * (abs(direction[0]) + abs(direction[1]))
    has_end = math.isfinite(end[0])
    for i in range(n):
        for j in range(n):
            if (i == 0 or j == 0 or i == n - 1 or j == n - 1) and not math.isinf(slowness[i, j]):
                x, y = j * cell - half, i * cell - half
                left = reach - (x * direction[0] + y * direction[1])
                length[i, j] = EXIT_COST * (math.hypot(x - end[0], y - end[1]) if has_end else left)
                waits[max(0, i - 1) : i + 2, max(0, j - 1) : j + 2] = True
    if has_end:
        _begin_at(end, slowness, cell, length, waits)
    for _ in range(rounds):
        change = 0.0
        for sweep in range(4):
            for ii in range(n):
                i = ii if sweep < 2 else n - 1 - ii
                for jj in range(n):
                    j = jj if sweep % 2 == 0 else n - 1 - jj
                    if not waits[i, j]:
                        continue
                    waits[i, j] = False
                    if math.isinf(slowness[i, j]):
                        continue
                    new = _godunov(length, slowness[i, j], cell, i, j)
                    if new < length[i, j]:
                        change = max(change, min(length[i, j], 1e6) - new)
                        length[i, j] = new
                        for k, m in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
                            if 0 <= k < n and 0 <= m < n and length[k, m] > new:
                                waits[k, m] = True
        if change < 0.5 * cell:
            break
