"""Distance fields around the UAV, and the shortest ways out through them."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit

EXIT_COST = 1.5
SLOWER = 1.0
"""Beside an obstacle a metre costs so much more than in proportion to the nearness."""
END_M = 1.0
"""The UAV goes so near to an end that it cannot reach."""


@njit(cache=True)
def stamp(points: np.ndarray, x: float, y: float, field: np.ndarray, cell: float, far: float) -> None:
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


@njit(cache=True)
def _godunov(way: np.ndarray, slowness: float, cell: float, i: int, j: int) -> float:
    n = way.shape[0]
    a = min(way[i - 1, j] if i > 0 else math.inf, way[i + 1, j] if i < n - 1 else math.inf)
    b = min(way[i, j - 1] if j > 0 else math.inf, way[i, j + 1] if j < n - 1 else math.inf)
    low, high = (a, b) if a < b else (b, a)
    step = slowness * cell
    if high - low >= step:
        return low + step
    return 0.5 * (low + high + math.sqrt(2.0 * step * step - (high - low) ** 2))


@njit(cache=True)
def _begin_at(end: np.ndarray, slowness: np.ndarray, cell: float, way: np.ndarray, waits: np.ndarray) -> None:
    """Begin the ways at the open cells nearest to ``end`` (2,), if any is within END_M of it."""
    n = way.shape[0]
    middle, reach = n // 2, math.ceil(END_M / cell)
    column, row = middle + round(end[0] / cell), middle + round(end[1] / cell)
    low_i, high_i, low_j, high_j = row - reach, row + reach + 1, column - reach, column + reach + 1
    nearest = END_M
    for begins in range(2):
        for i in range(max(0, low_i), min(n, high_i)):
            for j in range(max(0, low_j), min(n, high_j)):
                if math.isinf(slowness[i, j]):
                    continue
                away = math.hypot((j - middle) * cell - end[0], (i - middle) * cell - end[1])
                if begins and away <= nearest + cell:
                    way[i, j] = min(way[i, j], away)
                    waits[max(0, i - 1) : i + 2, max(0, j - 1) : j + 2] = True
                elif not begins:
                    nearest = min(nearest, away)


@njit(cache=True)
def ways_out(
    slowness: np.ndarray, cell: float, direction: np.ndarray, end: np.ndarray, way: np.ndarray, rounds: int
) -> None:
    """Fill ``way`` (n, n) with the length of the shortest way out of the window towards ``direction``, m.

    slowness (n, n): cost of a metre; inf where the UAV does not fit. The way ends on the window's edge. What
    then left to fly along ``direction`` is added, times EXIT_COST, because nobody knows what stands there.
    end (2,): m, from the middle; inf: there is none. The way leads to the open cells that are nearest to it.
    The method is fast sweeping (Zhao 2005) of the eikonal equation, which leaves out the cells that have no
    neighbour with a new, shorter way (Bak, McLaughlin and Renzi 2010).
    """
    n = way.shape[0]
    waits = np.zeros((n, n), np.bool_)
    half = 0.5 * (n - 1) * cell
    way[:] = math.inf
    reach = half * (abs(direction[0]) + abs(direction[1]))
    has_end = math.isfinite(end[0])
    for i in range(n):
        for j in range(n):
            if (i == 0 or j == 0 or i == n - 1 or j == n - 1) and not math.isinf(slowness[i, j]):
                x, y = j * cell - half, i * cell - half
                left = reach - (x * direction[0] + y * direction[1])
                way[i, j] = EXIT_COST * (math.hypot(x - end[0], y - end[1]) if has_end else left)
                waits[max(0, i - 1) : i + 2, max(0, j - 1) : j + 2] = True
    if has_end:
        _begin_at(end, slowness, cell, way, waits)
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
                    new = _godunov(way, slowness[i, j], cell, i, j)
                    if new < way[i, j]:
                        change = max(change, min(way[i, j], 1e6) - new)
                        way[i, j] = new
                        for k, m in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
                            if 0 <= k < n and 0 <= m < n and way[k, m] > new:
                                waits[k, m] = True
        if change < 0.5 * cell:
            break


@njit(cache=True)
def trace(way: np.ndarray, column: int, row: int, cells: np.ndarray) -> int:
    """Fill ``cells`` (m, 2: column, row) with the shortest way from the middle; return their number.

    column, row: of the middle among all cells of the plane.
    """
    half = way.shape[0] // 2
    i = j = half
    for count in range(cells.shape[0]):
        cells[count, 0], cells[count, 1] = column + j - half, row + i - half
        best_i, best_j, steepest = i, j, 0.0
        for k in range(max(0, i - 1), min(way.shape[0], i + 2)):
            for m in range(max(0, j - 1), min(way.shape[0], j + 2)):
                if (k != i or m != j) and (way[i, j] - way[k, m]) / math.hypot(k - i, m - j) > steepest:
                    steepest = (way[i, j] - way[k, m]) / math.hypot(k - i, m - j)
                    best_i, best_j = k, m
        if best_i == i and best_j == j:
            return count + 1
        i, j = best_i, best_j
    return cells.shape[0]


@njit(cache=True)
def favour(cells: np.ndarray, column: int, row: int, share: float, slowness: np.ndarray) -> None:
    """Lower ``slowness`` (n, n) to ``share`` of it in and around ``cells`` (m, 2: column, row).

    column, row: of the middle among all cells of the plane.
    """
    n = slowness.shape[0]
    marked = np.zeros((n, n), np.bool_)
    for k in range(cells.shape[0]):
        j, i = cells[k, 0] - column + n // 2, cells[k, 1] - row + n // 2
        marked[max(0, i - 1) : max(0, i + 2), max(0, j - 1) : max(0, j + 2)] = True
    for i in range(n):
        for j in range(n):
            if marked[i, j]:
                slowness[i, j] *= share


@njit(cache=True)
def close(
    distance: np.ndarray,
    limits: np.ndarray,
    inner: float,
    outer: float,
    column: int,
    row: int,
    stamp: float,
    hold: float,
    states: np.ndarray,
    slowness: np.ndarray,
) -> None:
    """Fill ``slowness`` (n, n) with the cost of a metre: inf where ``distance`` (n, n), m, leaves no room.

    It is 1 at the distance ``outer`` and 2 + SLOWER at ``inner``, m. What has room has a hysteresis.

    limits (3,): a cell closes below the first and opens above the last, m. Between them it stays as it was
    within the last ``hold`` s, and else closes below the middle one. states (m, m, 3): whether each cell of
    the plane was closed, when, and until when it is in any case, at its index modulo m > n. column, row: of
    the middle among these cells.
    """
    n, m = slowness.shape[0], states.shape[0]
    for i in range(n):
        k, h = (row + i - n // 2) % m, (column - n // 2) % m
        for j in range(n):
            d, state = distance[i, j], states[k, h]
            if limits[0] <= d <= limits[2] and stamp - state[1] <= hold:
                is_closed = state[0] > 0.0
            else:
                is_closed = d < limits[1]
            state[0], state[1] = 1.0 if is_closed else 0.0, stamp
            nearness = (outer - d) / (outer - inner)
            cost = 1.0 + nearness + SLOWER * (nearness * nearness)
            slowness[i, j] = math.inf if is_closed or stamp < state[2] else cost
            h = h + 1 if h + 1 < m else 0


@njit(cache=True)
def cross_section(
    way: np.ndarray, slowness: np.ndarray, from_m: float, to_m: float, cells: np.ndarray
) -> int:
    """Fill ``cells`` (m, 2: column, row from the middle) with the cross-section of the pocket behind; count.

    way, slowness (n, n): what `ways_out` takes and fills. The pocket is all that joins the middle by cells
    from which the way out is longer than from there. The cross-section is where it is longer by ``from_m`` to
    ``to_m``. Return 0 if the pocket reaches the edge, where nobody knows whether it goes on, or if there are
    more cells than fit.
    """
    n = way.shape[0]
    half = n // 2
    here = way[half, half]
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
        if here + from_m <= way[i, j] < here + to_m:
            if count == cells.shape[0]:
                return 0
            cells[count, 0], cells[count, 1] = j - half, i - half
            count += 1
        for a, b in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
            if not known[a, b] and not math.isinf(slowness[a, b]) and way[a, b] > here:
                known[a, b] = True
                waiting[end, 0], waiting[end, 1] = a, b
                end += 1
    return count
