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
    nearer. A point belongs to every layer whose height it is at most ``below`` under and ``above`` over; what
    ``above`` lacks to whole levels is added.
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
        level = math.floor((points[k, 2] - lowest) / level_m)
        if 0 <= i < n and 0 <= j < n and 0 <= level <= BITS:
            columns[i, j] |= np.uint64(1) << np.uint64(level)
    most = math.ceil(far / cell) + 1
    along_x = np.empty((n, n), np.float32)
    cells, is_new, occupied = np.zeros((n, n), np.bool_), np.ones(n, np.bool_), np.zeros(n, np.bool_)
    squared = np.empty(n, np.float32)
    distances = np.empty(most * most + 1)
    for k in range(distances.size):
        distances[k] = min(far, max(0.0, (math.sqrt(np.float32(k)) - 0.5) * cell))
    for layer in range(layers):
        band = bits_of(layer * count, layer * count + body)
        for i in range(n):
            is_new[i] = _is_changed(columns[i], band, cells[i]) or layer == 0
            if is_new[i]:
                occupied[i] = _along_row(cells[i], most, along_x[i])
        for i in range(n):
            first, last = max(0, i - most + 1), min(n, i + most)
            if not is_new[first:last].any():
                field[layer, i] = field[layer - 1, i]  # the layers mostly hold the same
                continue
            if not occupied[first:last].any():
                field[layer, i] = distances[-1]
                continue
            squared[:] = np.float32(most * most)
            for k in range(first, last):
                if occupied[k]:
                    rise = np.float32((k - i) * (k - i))
                    for j in range(n):
                        squared[j] = min(squared[j], along_x[k, j] + rise)
            for j in range(n):
                field[layer, i, j] = distances[int(squared[j])]


@njit(cache=True)
def _is_changed(columns: np.ndarray, band: np.uint64, cells: np.ndarray) -> bool:
    """Fill ``cells`` (n,) with whether a row's columns hold anything in the band; tell if that changes."""
    changed = False
    for j in range(columns.size):
        holds = (columns[j] & band) != 0
        changed |= holds != cells[j]
        cells[j] = holds
    return changed


@njit(cache=True)
def _along_row(cells: np.ndarray, most: int, squared: np.ndarray) -> bool:
    """Fill ``squared`` (n,) with the squared distance to the row's nearest obstacle, if there is one."""
    n = cells.size
    if not cells.any():
        return False
    away = most
    for j in range(n):
        if cells[j]:
            away = 0
        elif away < most:
            away += 1
        squared[j] = away
    away = most
    for j in range(n - 1, -1, -1):
        if squared[j] == 0.0:
            away = 0
        elif away < most:
            away += 1
        nearest = min(squared[j], np.float32(away))
        squared[j] = nearest * nearest
    return True
