"""Distance fields of layers of heights around the UAV."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit

BITS = 63
"""A column's levels are the bits of an integer."""


@njit(cache=True)
def band_of(lowest: float, low: float, high: float, level_m: float) -> np.uint64:
    """Return the bits of the levels from ``low`` to ``high``; ``lowest``: where bit 0 begins, m."""
    return bits_of(math.floor((low - lowest) / level_m), math.floor((high - lowest) / level_m))


@njit(cache=True)
def bits_of(first: int, last: int) -> np.uint64:
    """Return the bits of the levels ``first`` to ``last``; there are none beyond 0 and `BITS`."""
    mask = np.uint64(0)
    for bit in range(max(0, first), min(BITS, last) + 1):
        mask |= np.uint64(1) << np.uint64(bit)
    return mask


@njit(cache=True)
def levels_of_layer(layers: int, layer_m: float, body_m: float) -> int:
    """Return how many levels a layer is cut into: as many as the bits hold, at least 1.

    It is a whole number. Else a point near the edge of a layer's heights would count or not depending on
    which of the layers is the middle one, and a free layer would close when the UAV climbs into it.
    """
    count = 1
    while count < BITS and (layers - 1) * (count + 1) + math.floor(body_m * (count + 1) / layer_m) <= BITS:
        count += 1
    return count


@njit(cache=True)
def distance_layers(
    points: np.ndarray,
    middle_m: float,
    cell: float,
    layer_m: float,
    below: float,
    above: float,
    far: float,
    columns: np.ndarray,
    field: np.ndarray,
) -> None:
    """Fill ``field`` (layers, n, n) with the horizontal distance to the nearest obstacle, at most ``far`` m.

    points (m, 3): obstacles relative to the UAV, m; they count at the middle of their cell, and half a cell
    nearer. middle_m: height of the middle layer there. A point belongs to every layer whose height it is at
    most ``below`` under and ``above`` over; what ``above`` lacks to whole levels is added.
    columns (n, n) uint64: is overwritten. The transform is exact: along x, then along y.
    """
    layers, n, _ = field.shape
    half = n // 2
    lowest = -(layers // 2) * layer_m - below
    count = levels_of_layer(layers, layer_m, below + above)
    level_m = layer_m / count
    body = math.floor((below + above) / level_m)
    columns[:] = np.uint64(0)
    for k in range(points.shape[0]):
        i, j = math.floor(points[k, 1] / cell + 0.5) + half, math.floor(points[k, 0] / cell + 0.5) + half
        level = math.floor((points[k, 2] - middle_m - lowest) / level_m)
        if 0 <= i < n and 0 <= j < n and 0 <= level <= BITS:
            columns[i, j] |= np.uint64(1) << np.uint64(level)
    most = math.ceil(far / cell) + 1
    along_x = np.empty((n, n), np.float32)
    cells = np.zeros((n, n), np.bool_)
    begins, ends = np.zeros(n, np.int64), np.zeros(n, np.int64)  # of each row: where an obstacle is in reach
    firsts, lasts = np.zeros(n, np.int64), np.zeros(n, np.int64)  # of each row: which cells have changed
    squared = np.empty(n, np.float32)
    distances = np.empty(most * most + 1)
    for k in range(distances.size):
        distances[k] = min(far, max(0.0, (math.sqrt(np.float32(k)) - 0.5) * cell))
    for layer in range(layers):
        band = bits_of(layer * count, layer * count + body)
        for i in range(n):
            firsts[i], lasts[i] = _changed(columns[i], band, cells[i])
            if firsts[i] < lasts[i]:
                begins[i], ends[i] = _along_row(cells[i], most, along_x[i])
        for i in range(n):
            low, high = max(0, i - most + 1), min(n, i + most)
            first, last = 0, n
            if layer > 0:  # the layers mostly hold the same
                first = max(0, firsts[low:high].min() - most + 1)
                last = min(n, lasts[low:high].max() + most - 1)
                field[layer, i] = field[layer - 1, i]
                if lasts[low:high].max() == 0:
                    continue
            squared[first:last] = np.float32(most * most)
            for k in range(low, high):
                rise = np.float32((k - i) * (k - i))
                for j in range(max(first, begins[k]), min(last, ends[k])):
                    squared[j] = min(squared[j], along_x[k, j] + rise)
            for j in range(first, last):
                field[layer, i, j] = distances[int(squared[j])]


@njit(cache=True)
def _changed(columns: np.ndarray, band: np.uint64, cells: np.ndarray) -> tuple[int, int]:
    """Fill ``cells`` (n,) with whether a row's columns hold anything in the band.

    Return the first that changes, and the one after the last; n and 0 if none does.
    """
    first, last = columns.size, 0
    for j in range(columns.size):
        holds = (columns[j] & band) != 0
        if holds != cells[j]:
            first, last = min(first, j), j + 1
            cells[j] = holds
    return first, last


@njit(cache=True)
def _along_row(cells: np.ndarray, most: int, squared: np.ndarray) -> tuple[int, int]:
    """Fill ``squared`` (n,) with the squared distance to the row's nearest obstacle, at most ``most``.

    Only where one is nearer; return the first column there, and that after the last one.
    """
    n = cells.size
    begin, end = n, 0
    for j in range(n):
        if cells[j]:
            begin, end = min(begin, j), j
    if begin == n:
        return 0, 0
    begin, end = max(0, begin - most + 1), min(n, end + most)
    away = most
    for j in range(begin, end):
        if cells[j]:
            away = 0
        elif away < most:
            away += 1
        squared[j] = away
    away = most
    for j in range(end - 1, begin - 1, -1):
        if squared[j] == 0.0:
            away = 0
        elif away < most:
            away += 1
        nearest = min(squared[j], np.float32(away))
        squared[j] = nearest * nearest
    return begin, end


@njit(cache=True)
def shade(
    field: np.ndarray, plane: np.ndarray, known: np.ndarray, unseen: np.ndarray, at: np.ndarray, far: float
) -> None:
    """Lower ``field`` (layers, n, n) to what a plane shows (n, n), m, where nobody has looked.

    There ``known`` (n, n), m, counts, too. In the middle layer the plane counts everywhere. unseen (layers,
    k, k): 0 where somebody has looked. at (n,): the row or column of ``unseen`` that each cell is in. far: m,
    the greatest value in ``field``; where nothing nearer is known, nothing is lowered.
    """
    layers, n, _ = field.shape
    both = np.minimum(plane, known)
    begins = np.searchsorted(at, np.arange(unseen.shape[1] + 1))  # of the cells that each row is of
    is_near = np.zeros(unseen.shape[1:], np.bool_)
    for i in range(n):
        for j in range(n):
            if both[i, j] < far:
                is_near[at[i], at[j]] = True
    for layer in range(layers):
        for row in range(unseen.shape[1]):
            for column in range(unseen.shape[2]):
                if unseen[layer, row, column] == 0 or not is_near[row, column]:
                    continue
                for i in range(begins[row], begins[row + 1]):
                    for j in range(begins[column], begins[column + 1]):
                        field[layer, i, j] = min(field[layer, i, j], both[i, j])
    middle = field[layers // 2]
    for i in range(n):
        for j in range(n):
            middle[i, j] = min(middle[i, j], plane[i, j])
