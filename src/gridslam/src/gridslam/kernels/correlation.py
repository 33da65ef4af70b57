"""Correlation of a local map with another over a window of poses (Olson 2009), by multi-resolution search.

A table holds two values for each cell, each 0..255: how well a point fits there (`FITS`), and how much it
contradicts free space there (`CLASHES`). A pose's score is the share of comparisons that agree: fits /
max(fits + clashes, least). Cells that the other map has not seen do not count.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

FITS, CLASHES = 0, 1
FULL = 255.0
BLOCK = 8
"""Side, in shifts, of the squares that share a bound."""


class Reference(NamedTuple):
    """The map that stays."""

    table: np.ndarray
    """(h, w, 2)"""
    points_xy: np.ndarray
    """(m, 2) its points, in cells of its table."""


class Query(NamedTuple):
    """The map that is shifted and turned."""

    table: np.ndarray
    """(h, w, 2)"""
    angles_rad: np.ndarray
    """(angles,)"""
    cells: np.ndarray
    """(angles, n, 2) int64: its points for every angle, in cells of the reference's table."""
    corners_xy: np.ndarray
    """(angles, 2) position of its table's corner in these cells, at shift zero."""


class Blocks(NamedTuple):
    """Blocks of shifts with upper bounds of their scores."""

    half: int
    """Shifts reach from -half to half."""
    least: float
    """Fewer comparisons than this lower the score."""
    bounds: np.ndarray
    """(angles, n, n) of the scores of n x n blocks of BLOCK x BLOCK shifts."""
    order: np.ndarray
    """Flat indices of ``bounds``, best first."""


@njit(cache=True, nogil=True)
def mark_free(lidar_xy: np.ndarray, ends_xy: np.ndarray, hits: np.ndarray, free: np.ndarray) -> None:
    """Mark in ``free`` (h, w) the cells that beams cross; all in cells from the table's corner.

    A beam that hit something (``hits``) is free only up to two cells before its end.
    """
    height, width = free.shape
    for beam in range(ends_xy.shape[0]):
        dx, dy = ends_xy[beam, 0] - lidar_xy[0], ends_xy[beam, 1] - lidar_xy[1]
        length = np.hypot(dx, dy)
        last = int(length - 2.0 if hits[beam] else length)
        for step in range(last + 1):
            x = int(np.floor(lidar_xy[0] + dx * step / length))
            y = int(np.floor(lidar_xy[1] + dy * step / length))
            if 0 <= x < width and 0 <= y < height:
                free[y, x] = True


@njit(cache=True, nogil=True)
def stamp_fits(cells: np.ndarray, profile: np.ndarray, fits: np.ndarray) -> None:
    """Write a square ``profile`` of fits into the cells (h, w) around each point's cell (n, 2: x, y)."""
    height, width = fits.shape
    reach = profile.shape[0] // 2
    for i in range(cells.shape[0]):
        x, y = cells[i, 0], cells[i, 1]
        for row in range(max(0, y - reach), min(height, y + reach + 1)):
            for column in range(max(0, x - reach), min(width, x + reach + 1)):
                fits[row, column] = max(fits[row, column], profile[row - y + reach, column - x + reach])


@njit(cache=True, nogil=True, inline="always")
def _overlap(first: int, count: int, size: int) -> tuple[int, int]:
    """Return the first and one past the last i of 0 <= i < count for which 0 <= first + i < size."""
    return max(0, -first), min(count, size - first)


@njit(cache=True, nogil=True)
def block_sums(phases: np.ndarray, cells: np.ndarray, half: int, sums: np.ndarray) -> None:
    """Sum the greatest fits and the least clashes that the points meet in each block of BLOCK x BLOCK shifts.

    Args:
        phases: (BLOCK, BLOCK, h, 2 w) uint8: [y, x, row, column] is the value, as in a table, of cell row
            BLOCK + y, column BLOCK + x of a pooled table. That holds, per cell, the greatest FITS and the
            least CLASHES of the BLOCK x BLOCK cells from it on. Its first cell is BLOCK before the table's.
        cells: (angles, points, 2) int64: the points' cells for every angle.
        half: shifts reach from -half to half.
        sums: (angles, n, 2 n) int32, gets the FITS and CLASHES of the n x n blocks. Initially 0.
    """
    height, width, count = phases.shape[2], phases.shape[3] // 2, sums.shape[1]
    for a in range(cells.shape[0]):
        for i in range(cells.shape[1]):
            x, y = cells[a, i, 0] + BLOCK - half, cells[a, i, 1] + BLOCK - half
            column, row = x // BLOCK, y // BLOCK
            left, right = _overlap(column, count, width)
            if left >= right:
                continue
            values = phases[y % BLOCK, x % BLOCK]
            low, high = _overlap(row, count, height)
            for block in range(low, high):
                more = values[row + block, 2 * (column + left) : 2 * (column + right)]
                total = sums[a, block, 2 * left : 2 * right]
                for k in range(total.size):
                    total[k] += more[k]


@njit(cache=True, nogil=True)
def _shift_sums(table: np.ndarray, cells: np.ndarray, dx: int, dy: int, sums: np.ndarray) -> None:
    """Sum the values at the points (n, 2) for all shifts of the block whose first one is dx, dy.

    ``table`` is (h, 2 w). ``sums`` (BLOCK, 2 BLOCK) int32 gets FITS and CLASHES. Points outside count as 0.
    """
    height, width = table.shape[0], table.shape[1] // 2
    sums[:] = 0
    for i in range(cells.shape[0]):
        x, y = cells[i, 0] + dx, cells[i, 1] + dy
        left, right = _overlap(x, BLOCK, width)
        if left >= right:
            continue
        low, high = _overlap(y, BLOCK, height)
        for row in range(low, high):
            more = table[y + row, 2 * (x + left) : 2 * (x + right)]
            total = sums[row, 2 * left : 2 * right]
            for k in range(total.size):
                total[k] += more[k]


@njit(cache=True, nogil=True)
def _clashes_back(
    table: np.ndarray, points_xy: np.ndarray, x: float, y: float, cos: float, sin: float
) -> float:
    """Clashes of the reference's points (n, 2) with the query's table, when the query stands at x, y, angle.

    Everything in cells; the query's table has its corner where its cell [0, 0] lies in the query's frame.
    """
    height, width = table.shape[:2]
    clashes = 0
    for i in range(points_xy.shape[0]):
        from_x, from_y = points_xy[i, 0] - x, points_xy[i, 1] - y
        column = int(np.floor(cos * from_x + sin * from_y))
        row = int(np.floor(-sin * from_x + cos * from_y))
        if 0 <= column < width and 0 <= row < height:
            clashes += table[row, column, CLASHES]
    return clashes / FULL


@njit(cache=True, nogil=True)
def best_shift(
    blocks: Blocks, reference: Reference, query: Query, circle: np.ndarray, floor: float
) -> tuple[float, int, int, int]:
    """Search blocks by falling bound; return score, angle's index, dx and dy (cells) of the best shift.

    Args:
        blocks: the shifts to search.
        reference: the map that stays.
        query: the map that is shifted.
        circle: (3,) dx, dy and radius; shifts inside are left out.
        floor: least score of interest. If none is better, floor is returned as the score.
    """
    half, least, cells = blocks.half, blocks.least, query.cells
    side = blocks.bounds.shape[1]
    best, best_a, best_dx, best_dy = floor, 0, 0, 0
    flat = blocks.bounds.reshape(-1)
    table = reference.table.reshape(reference.table.shape[0], -1)
    sums = np.empty((BLOCK, 2 * BLOCK), np.int32)
    for index in blocks.order:
        if flat[index] <= best:
            break
        a, rest = index // (side * side), index % (side * side)
        cos, sin = np.cos(query.angles_rad[a]), np.sin(query.angles_rad[a])
        first_x, first_y = (rest % side) * BLOCK - half, (rest // side) * BLOCK - half
        _shift_sums(table, cells[a], first_x, first_y, sums)
        for dy in range(first_y, min(first_y + BLOCK, half + 1)):
            for dx in range(first_x, min(first_x + BLOCK, half + 1)):
                column = 2 * (dx - first_x)
                fits = sums[dy - first_y, column + FITS] / FULL
                clashes = sums[dy - first_y, column + CLASHES] / FULL
                if fits / max(fits + clashes, least) <= best:
                    continue
                if (dx - circle[0]) ** 2 + (dy - circle[1]) ** 2 < circle[2] ** 2:
                    continue
                x, y = query.corners_xy[a, 0] + dx, query.corners_xy[a, 1] + dy
                clashes += _clashes_back(query.table, reference.points_xy, x, y, cos, sin)
                score = fits / max(fits + clashes, least)
                if score > best:
                    best, best_a, best_dx, best_dy = score, a, dx, dy
    return best, best_a, best_dx, best_dy
