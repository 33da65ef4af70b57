"""A grid of surface elements: in each cell the mean point and the mean normal of the surface in it.

``points`` (n, 5) are rows of a point's x, y in m, its surface's unit normal x, y, and 1; if the surface is
unknown, the normal is (0, 0). A table is a hash table with linear probing. So it covers the whole plane and
needs memory only for cells that hold points.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gridslam.kernels.nearest import NearestPoints
from kernel_cache.compiler import njit

FLAT_MIN = 0.8
"""A cell is flat if its mean normal is at least this long."""
FACING_MIN = 0.5
"""Cosine of the greatest angle between the normals of a beam's surface and of a cell."""

EMPTY = np.iinfo(np.int64).min
"""Column of a slot that has never held a cell."""
ROW_STEP = 73_856_093
"""Slots from one row of cells to the next, before the remainder; neighbours in a row are side by side."""


class SurfelTable(NamedTuple):
    """Cells of one size; see above. At least one slot must stay empty."""

    cells: np.ndarray
    """(slots, 2) int64: which cell (i, j) each slot holds, or EMPTY. Their number is a power of two."""
    sums: np.ndarray
    """(slots, 5) the sum of the rows in each cell."""

    @classmethod
    def empty(cls, slots: int) -> SurfelTable:
        """Return a table of so many slots, a power of two."""
        return cls(np.full((slots, 2), EMPTY, np.int64), np.zeros((slots, 5)))


@njit(cache=True, nogil=True)
def add_points(points: np.ndarray, sign: float, cell_m: float, table: SurfelTable) -> int:
    """Add points (n, 5) to the table with sign 1.0, or take them out with -1.0.

    Return the number of slots newly taken.
    """
    cells, sums = table
    taken = 0
    for k in range(points.shape[0]):
        i, j = math.floor(points[k, 0] / cell_m), math.floor(points[k, 1] / cell_m)
        slot = _slot(i, j, cells)
        if cells[slot, 0] == EMPTY:
            cells[slot, 0], cells[slot, 1] = i, j
            taken += 1
        for c in range(5):
            sums[slot, c] += sign * points[k, c]
        if sums[slot, 4] < 0.5:
            sums[slot] = 0.0
    return taken


@njit(cache=True, nogil=True)
def move_cells(table: SurfelTable, other: SurfelTable) -> int:
    """Copy the cells that hold points into another, empty table; return their number."""
    moved = 0
    for old in range(table.cells.shape[0]):
        if table.sums[old, 4] > 0.5:
            slot = _slot(table.cells[old, 0], table.cells[old, 1], other.cells)
            other.cells[slot] = table.cells[old]
            other.sums[slot] = table.sums[old]
            moved += 1
    return moved


@njit(cache=True, nogil=True)
def find_surfels(
    x: float,
    y: float,
    yaw: float,
    beams: np.ndarray,
    reach_m: float,
    cell_m: float,
    table: SurfelTable,
    nearby: NearestPoints,
) -> tuple[int, float]:
    """Write the nearest mean point to each beam's end into ``nearby``.

    Return their number, and the sum of 1 / (number of points in the cell) over them.

    ``beams`` (n, 7) are those of `nearest`, in m. A beam gets the normal of the cell that was found, and the
    weight along the surface 0 (flat) or 1. Its own normal is in columns 2 and 3, (0, 0) if unknown. Means
    farther than ``reach_m`` or in cells that face another way do not count.
    """
    cells, sums = table
    points, which = nearby
    cos, sin = math.cos(yaw), math.sin(yaw)
    kernel = math.ceil(reach_m / cell_m)
    found, newness = 0, 0.0
    for b in range(beams.shape[0]):
        px = x + cos * beams[b, 0] - sin * beams[b, 1]
        py = y + sin * beams[b, 0] + cos * beams[b, 1]
        nx, ny = cos * beams[b, 2] - sin * beams[b, 3], sin * beams[b, 2] + cos * beams[b, 3]
        i, j = math.floor(px / cell_m), math.floor(py / cell_m)
        best = reach_m * reach_m
        best_slot = -1
        for cj in range(j - kernel, j + kernel + 1):
            for ci in range(i - kernel, i + kernel + 1):
                slot = _slot(ci, cj, cells)
                number = sums[slot, 4]
                if number < 0.5:
                    continue
                if sums[slot, 2] * nx + sums[slot, 3] * ny < FACING_MIN * number * (
                    nx * nx + ny * ny
                ) * _length(sums[slot]):
                    continue
                dx, dy = px - sums[slot, 0] / number, py - sums[slot, 1] / number
                if dx * dx + dy * dy < best:
                    best, best_slot = dx * dx + dy * dy, slot
        if best_slot < 0:
            continue
        sum_of = sums[best_slot]
        number, length = sum_of[4], _length(sum_of)
        points[found, 0], points[found, 1], which[found] = sum_of[0] / number, sum_of[1] / number, b
        found += 1
        newness += 1.0 / number
        if length >= FLAT_MIN:
            mx, my = sum_of[2] / (number * length), sum_of[3] / (number * length)
            beams[b, 4], beams[b, 5] = cos * mx + sin * my, cos * my - sin * mx
            beams[b, 6] = 0.0
        else:
            beams[b, 4], beams[b, 5], beams[b, 6] = 1.0, 0.0, 1.0
    return found, newness


@njit(cache=True, nogil=True, inline="always")
def _slot(i: int, j: int, cells: np.ndarray) -> int:
    """Return the slot that holds a cell, or else the empty one where it belongs."""
    mask = cells.shape[0] - 1
    slot = (i + ROW_STEP * j) & mask
    while (cells[slot, 0] != i or cells[slot, 1] != j) and cells[slot, 0] != EMPTY:
        slot = (slot + 1) & mask
    return slot


@njit(cache=True, nogil=True, inline="always")
def _length(sums: np.ndarray) -> float:
    """Length of the mean normal."""
    return math.hypot(sums[2], sums[3]) / sums[4]
