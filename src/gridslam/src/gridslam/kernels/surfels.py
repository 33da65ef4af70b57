"""A grid of surface elements: in each cell the mean point and the mean normal of the surface in it.

``points`` (n, 5) are rows of a point's x, y in m, its surface's unit normal x, y, and 1; if the surface is
unknown, the normal is (0, 0). A table covers the whole plane: cell (i, j) is kept in row j and column i,
modulo the table's size. If two cells share a place, the place belongs to the one that was written last.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from gridslam.kernels.nearest import NearestPoints

FLAT_MIN = 0.8
"""A cell is flat if its mean normal is at least this long."""
FACING_MIN = 0.5
"""Cosine of the greatest angle between the normals of a beam's surface and of a cell."""


class SurfelTable(NamedTuple):
    """Cells of one size; see above."""

    cells: np.ndarray
    """(side, side, 2) int64: which cell (i, j) each place holds."""
    sums: np.ndarray
    """(side, side, 5) the sum of the rows in each cell."""


@njit(cache=True, nogil=True)
def add_points(points: np.ndarray, sign: float, cell_m: float, table: SurfelTable) -> None:
    """Add points (n, 5) to the table with sign 1.0, or take them out with -1.0."""
    cells, sums = table
    side = cells.shape[0]
    for k in range(points.shape[0]):
        i, j = math.floor(points[k, 0] / cell_m), math.floor(points[k, 1] / cell_m)
        row, column = j % side, i % side
        if cells[row, column, 0] != i or cells[row, column, 1] != j:
            if sign < 0.0:
                continue
            cells[row, column, 0], cells[row, column, 1] = i, j
            sums[row, column] = 0.0
        for c in range(5):
            sums[row, column, c] += sign * points[k, c]


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
) -> int:
    """Write the nearest mean point to each beam's end into ``nearby``; return their number.

    ``beams`` (n, 7) are those of `nearest`, in m. A beam gets the normal of the cell that was found, and the
    weight along the surface 0 (flat) or 1. Its own normal is in columns 2 and 3, (0, 0) if unknown. Means
    farther than ``reach_m`` or in cells that face another way do not count.
    """
    cells, sums = table
    points, which = nearby
    side = cells.shape[0]
    cos, sin = math.cos(yaw), math.sin(yaw)
    kernel = math.ceil(reach_m / cell_m)
    found = 0
    for b in range(beams.shape[0]):
        px = x + cos * beams[b, 0] - sin * beams[b, 1]
        py = y + sin * beams[b, 0] + cos * beams[b, 1]
        nx, ny = cos * beams[b, 2] - sin * beams[b, 3], sin * beams[b, 2] + cos * beams[b, 3]
        i, j = math.floor(px / cell_m), math.floor(py / cell_m)
        best = reach_m * reach_m
        best_row, best_column = -1, -1
        for cj in range(j - kernel, j + kernel + 1):
            row = cj % side
            for ci in range(i - kernel, i + kernel + 1):
                column = ci % side
                if cells[row, column, 0] != ci or cells[row, column, 1] != cj:
                    continue
                number = sums[row, column, 4]
                if number < 0.5:
                    continue
                if sums[row, column, 2] * nx + sums[row, column, 3] * ny < FACING_MIN * number * (
                    nx * nx + ny * ny
                ) * _length(sums[row, column]):
                    continue
                dx, dy = px - sums[row, column, 0] / number, py - sums[row, column, 1] / number
                if dx * dx + dy * dy < best:
                    best, best_row, best_column = dx * dx + dy * dy, row, column
        if best_row < 0:
            continue
        sum_of = sums[best_row, best_column]
        number, length = sum_of[4], _length(sum_of)
        points[found, 0], points[found, 1], which[found] = sum_of[0] / number, sum_of[1] / number, b
        found += 1
        if length >= FLAT_MIN:
            mx, my = sum_of[2] / (number * length), sum_of[3] / (number * length)
            beams[b, 4], beams[b, 5] = cos * mx + sin * my, cos * my - sin * mx
            beams[b, 6] = 0.0
        else:
            beams[b, 4], beams[b, 5], beams[b, 6] = 1.0, 0.0, 1.0
    return found


@njit(cache=True, nogil=True, inline="always")
def _length(sums: np.ndarray) -> float:
    """Length of the mean normal."""
    return math.hypot(sums[2], sums[3]) / sums[4]
