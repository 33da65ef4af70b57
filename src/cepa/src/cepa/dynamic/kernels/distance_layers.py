"""Distance fields of layers of heights around the UAV."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit

BITS = 63
"""A column's levels are the bits of an integer."""
LANES = 64
"""Rows are worked on in blocks of so many cells, which leave no rest that a processor takes one by one."""


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


def squares_for(side: int, cell: float, far: float) -> np.ndarray:
    """Return the array (side + 1, m) that `distance_layers` works in; m: ``side`` or a little more.

    The narrower its integers, the more of them a processor takes at once. They must hold twice the square of
    the cells to ``far``.
    """
    most = _cells_to(far, cell)
    integers = np.uint16 if 2 * most * most <= np.iinfo(np.uint16).max else np.uint32
    return np.full((side + 1, -(-side // LANES) * LANES), most * most, integers)


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
    squares: np.ndarray,
    field: np.ndarray,
) -> None:
    """Fill ``field`` (layers, n, n) with the horizontal distance to the nearest obstacle, at most ``far`` m.

    points (m, 3): obstacles relative to the UAV, m; they count at the middle of their cell, and half a cell
    nearer. middle_m: height of the middle layer there. A point belongs to every layer whose height it is at
    most ``below`` under and ``above`` over; what ``above`` lacks to whole levels is added.
    columns (n, n) uint64 and squares (see `squares_for`) are overwritten. The transform is exact: along x,
    then along y. A layer is what the one below it is, but for what is near cells that have changed.
    """
    layers, n, _ = field.shape
    lowest = -(layers // 2) * layer_m - below
    count = levels_of_layer(layers, layer_m, below + above)
    level_m = layer_m / count
    body = math.floor((below + above) / level_m)
    _fill_columns(points, middle_m, lowest, cell, level_m, columns)
    held, begins, ends = _extents(columns)
    most = _cells_to(far, cell)
    distances = np.empty(most * most + 1)
    for k in range(distances.size):
        distances[k] = min(far, max(0.0, (math.sqrt(np.float32(k)) - 0.5) * cell))
    cells, reaches = np.zeros((n, n), np.bool_), np.zeros((n, 2), np.int64)
    changed, band = (
        np.empty((n, 2), np.int64),
        np.uint64(0),
    )  # of each row: the first cell, and behind the last
    for layer in range(layers):
        before, band = band, bits_of(layer * count, layer * count + body)
        changed[:, 0], changed[:, 1] = (n, 0) if layer else (0, n)
        if layer:
            field[layer] = field[layer - 1]
        for i in range(n):
            if held[i] & (before ^ band) == 0:
                continue
            first, last = _changed(columns[i], band, begins[i], ends[i], cells[i])
            if first < last:
                reaches[i] = _along_row(cells[i], most, squares[i])
                first, last = max(0, first - most + 1), min(n, last + most - 1)
                for k in range(max(0, i - most + 1), min(n, i + most)):
                    changed[k, 0], changed[k, 1] = min(changed[k, 0], first), max(changed[k, 1], last)
        for i in range(n):
            if changed[i, 0] < changed[i, 1]:
                _fill_row(i, changed[i, 0], changed[i, 1], reaches, squares, distances, field[layer, i])


@njit(cache=True)
def _cells_to(far: float, cell: float) -> int:
    """Return from how many cells on nothing is nearer than ``far``."""
    return math.ceil(far / cell) + 1


@njit(cache=True)
def _fill_columns(
    points: np.ndarray, middle_m: float, lowest: float, cell: float, level_m: float, columns: np.ndarray
) -> None:
    """Fill ``columns`` (n, n) with the levels at which ``points`` (m, 3) are in each cell, as bits."""
    n = columns.shape[0]
    half = n // 2
    columns[:] = np.uint64(0)
    for k in range(points.shape[0]):
        i, j = math.floor(points[k, 1] / cell + 0.5) + half, math.floor(points[k, 0] / cell + 0.5) + half
        level = math.floor((points[k, 2] - middle_m - lowest) / level_m)
        if 0 <= i < n and 0 <= j < n and 0 <= level <= BITS:
            columns[i, j] |= np.uint64(1) << np.uint64(level)


@njit(cache=True)
def _extents(columns: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the levels that each row of ``columns`` (n, n) holds, and its cells that hold any: from, to."""
    n = columns.shape[0]
    held, begins, ends = np.zeros(n, np.uint64), np.full(n, n), np.zeros(n, np.int64)
    for i in range(n):
        for j in range(n):
            if columns[i, j]:
                held[i] |= columns[i, j]
                begins[i], ends[i] = min(begins[i], j), j + 1
    return held, begins, ends


@njit(cache=True)
def _changed(
    columns: np.ndarray, band: np.uint64, begin: int, end: int, cells: np.ndarray
) -> tuple[int, int]:
    """Fill ``cells`` (n,) with whether a row's columns hold anything in the band.

    Only from ``begin`` to ``end``. Return the first that changes, and the one after the last; n and 0 if none
    does.
    """
    first, last = columns.size, 0
    for j in range(begin, end):
        holds = (columns[j] & band) != 0
        if holds != cells[j]:
            first, last = min(first, j), j + 1
            cells[j] = holds
    return first, last


@njit(cache=True)
def _along_row(cells: np.ndarray, most: int, squared: np.ndarray) -> tuple[int, int]:
    """Fill ``squared`` (n or more) with the squared distance to the row's nearest obstacle, at most ``most``.

    Return the first cell that has one nearer than ``most``, and the one after the last; 0 and 0 if none has.
    """
    n, away = cells.size, most
    begin, end = n, 0
    for j in range(n):
        if cells[j]:
            away, begin, end = 0, min(begin, j), j
        elif away < most:
            away += 1
        squared[j] = away
    away = most
    for j in range(n - 1, -1, -1):
        if cells[j]:
            away = 0
        elif away < most:
            away += 1
        nearest = min(int(squared[j]), away)
        squared[j] = nearest * nearest
    return (0, 0) if begin == n else (max(0, begin - most + 1), min(n, end + most))


@njit(cache=True)
def _fill_row(
    i: int,
    first: int,
    last: int,
    reaches: np.ndarray,
    squares: np.ndarray,
    distances: np.ndarray,
    row: np.ndarray,
) -> None:
    """Fill row ``i`` of a layer from ``first`` to before ``last`` with ``distances`` (most**2 + 1,), m.

    reaches (n, 2): the cells of each row that have an obstacle near in the row, as `_along_row` returns them.
    squares: what that fills, row by row. Its last row is overwritten.
    """
    none = distances.size - 1
    most, integer = int(math.sqrt(none)), squares.dtype.type
    begin = LANES * (first // LANES)
    width = LANES * ((last - begin + LANES - 1) // LANES)
    least = squares[-1, begin : begin + width]
    least[:] = none
    for k in range(max(0, i - most + 1), min(reaches.shape[0], i + most)):
        if reaches[k, 0] >= last or reaches[k, 1] <= first:
            continue
        rise, along = (k - i) * (k - i), squares[k, begin : begin + width]
        for j in range(width):  # without a branch, so that several cells go at once
            square = integer(along[j] + rise)
            least[j] = square if square < least[j] else least[j]
    for j in range(first, last):
        row[j] = distances[least[j - begin]]


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
