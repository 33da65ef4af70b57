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
BLOCK, PAIR = 8, 2
"""Side, in shifts, of the squares that share a bound: first blocks, then 2 x 2 squares in them."""


class Reference(NamedTuple):
    """The map that stays."""

    table: np.ndarray
    """(h, w, 2)"""
    pairs: np.ndarray
    """As ``pooled`` of `block_bounds`, of PAIR x PAIR cells."""
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
    """Of `block_bounds`."""
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


@njit(cache=True, nogil=True)
def _sums(table: np.ndarray, cells: np.ndarray, dx: int, dy: int) -> tuple[float, float]:
    """Sum both values at every point (n, 2) of integer cells, moved by dx, dy.

    Points outside count as zero.
    """
    height, width = table.shape[:2]
    fits = clashes = 0
    for i in range(cells.shape[0]):
        x, y = cells[i, 0] + dx, cells[i, 1] + dy
        if 0 <= x < width and 0 <= y < height:
            fits += table[y, x, FITS]
            clashes += table[y, x, CLASHES]
    return fits / FULL, clashes / FULL


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
def block_bounds(pooled: np.ndarray, cells: np.ndarray, half: int, least: float) -> np.ndarray:
    """Bound the score of each block of BLOCK x BLOCK shifts from above: (angles, n, n) float32.

    ``pooled`` holds, per cell, the greatest FITS and the least CLASHES of the BLOCK x BLOCK cells from it on,
    its first cell being BLOCK before the table's; ``cells`` (angles, n, 2) int64 are the points' cells for
    every angle; shifts reach from -half to half. ``least``: fewer comparisons than this lower the score.
    """
    blocks = (2 * half + BLOCK) // BLOCK
    bounds = np.empty((cells.shape[0], blocks, blocks), dtype=np.float32)
    for a in range(cells.shape[0]):
        for by in range(blocks):
            for bx in range(blocks):
                fits, clashes = _sums(pooled, cells[a], (bx + 1) * BLOCK - half, (by + 1) * BLOCK - half)
                bounds[a, by, bx] = fits / max(fits + clashes, least)
    return bounds


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
    for index in blocks.order:
        if flat[index] <= best:
            break
        a, rest = index // (side * side), index % (side * side)
        cos, sin = np.cos(query.angles_rad[a]), np.sin(query.angles_rad[a])
        first_x, first_y = (rest % side) * BLOCK - half, (rest // side) * BLOCK - half
        for part in range((BLOCK // PAIR) ** 2):
            x0 = first_x + part % (BLOCK // PAIR) * PAIR
            y0 = first_y + part // (BLOCK // PAIR) * PAIR
            fits, clashes = _sums(reference.pairs, cells[a], x0 + PAIR, y0 + PAIR)
            if fits / max(fits + clashes, least) <= best:
                continue
            for dy in range(y0, min(y0 + PAIR, half + 1)):
                for dx in range(x0, min(x0 + PAIR, half + 1)):
                    if (dx - circle[0]) ** 2 + (dy - circle[1]) ** 2 < circle[2] ** 2:
                        continue
                    fits, clashes = _sums(reference.table, cells[a], dx, dy)
                    if fits / max(fits + clashes, least) <= best:
                        continue
                    x, y = query.corners_xy[a, 0] + dx, query.corners_xy[a, 1] + dy
                    clashes += _clashes_back(query.table, reference.points_xy, x, y, cos, sin)
                    score = fits / max(fits + clashes, least)
                    if score > best:
                        best, best_a, best_dx, best_dy = score, a, dx, dy
    return best, best_a, best_dx, best_dy
