"""Correlation of a local map with another over a window of poses (Olson 2009), by multi-resolution search.

A table holds two values for each cell, each 0..255: how well a point fits there (`FITS`), and how much it
contradicts free space there (`CLASHES`). A pose's score is the share of comparisons that agree: fits /
max(fits + clashes, least). Cells that the other map has not seen do not count.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kernel_cache.compiler import njit

FITS, CLASHES = 0, 1
FULL = 255.0
BLOCK = 8
"""Side, in shifts, of the largest squares that share a bound; a power of 2. Each is split into quarters."""
LEVELS = 3
"""The side of the largest squares is 2 to the power of this."""
STACK = 3 * LEVELS + 1
"""At most this many squares wait to be split."""


class Reference(NamedTuple):
    """The map that stays."""

    levels: np.ndarray
    """(levels, h + m, 2 (w + m)) uint8: in level k, column 2 x + FITS of row y holds the greatest FITS, and
    2 x + CLASHES the least CLASHES, of the 2^k x 2^k cells from x, y on. Around the table there is a margin
    of BLOCK zeros, and perhaps more after its end.
    """
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
    turns_rad: np.ndarray
    """(angles,) the angles, from the window's middle on."""
    factor: np.ndarray
    """(3, 3): a shift dx, dy (cells) and turn is left out if this times (dx, dy, turn) is longer than 1."""


@njit(cache=True, nogil=True)
def mark_free(lidar_xy: np.ndarray, ends_xy: np.ndarray, hits: np.ndarray, free: np.ndarray) -> None:
    """Mark in ``free`` (h, w) the cells that beams cross; all in cells from the table's corner.

    A beam that hit something (``hits``) is free only up to two cells before its end.
    """
    height, width = free.shape
    cells, from_x, from_y = free.ravel(), lidar_xy[0], lidar_xy[1]
    for beam in range(ends_xy.shape[0]):
        dx, dy = ends_xy[beam, 0] - from_x, ends_xy[beam, 1] - from_y
        length = np.hypot(dx, dy)
        last = int(length - 2.0 if hits[beam] else length)
        along_x, along_y = dx / max(length, 1.0), dy / max(length, 1.0)
        to_x, to_y = from_x + along_x * last, from_y + along_y * last
        is_inside = min(from_x, to_x) >= 0.0 and max(from_x, to_x) < width
        if is_inside and min(from_y, to_y) >= 0.0 and max(from_y, to_y) < height:
            for step in range(last + 1):
                x, y = np.int64(from_x + along_x * step), np.int64(from_y + along_y * step)
                cells[np.uint64(y * width + x)] = True
            continue
        for step in range(last + 1):
            x, y = np.int64(np.floor(from_x + along_x * step)), np.int64(np.floor(from_y + along_y * step))
            if 0 <= x < width and 0 <= y < height:
                free[y, x] = True


@njit(cache=True, nogil=True)
def fill_table(
    cells: np.ndarray, profile: np.ndarray, free: np.ndarray, fits: np.ndarray, table: np.ndarray
) -> None:
    """Write a table (h, w, 2) of zeros, from points' cells (n, 2: x, y) and the cells that are free (h, w).

    ``profile`` holds the fits around a point's cell, a square whose middle alone is 255. ``fits`` (h, w) of
    zeros gets the table's fits.
    """
    height, width = free.shape
    reach = profile.shape[0] // 2
    for i in range(cells.shape[0]):
        x, y = cells[i, 0], cells[i, 1]
        if fits[y, x] == 255:  # a point was here before
            continue
        left, right = max(0, x - reach), min(width, x + reach + 1)
        for row in range(max(0, y - reach), min(height, y + reach + 1)):
            known, new = fits[row, left:right], profile[row - y + reach, left - x + reach :]
            for k in range(right - left):
                known[k] = max(known[k], new[k])
    for row in range(height):
        for column in range(width):
            table[row, column, FITS] = fits[row, column]
            table[row, column, CLASHES] = free[row, column] * (255 - fits[row, column])


@njit(cache=True, nogil=True)
def pool(table: np.ndarray, levels: np.ndarray, phases: np.ndarray) -> None:
    """Write a table's `Reference.levels`, and the input of `block_sums`, which is the next level."""
    height, width = levels.shape[1], levels.shape[2] // 2
    fits, clashes = np.zeros((height, width), np.uint8), np.zeros((height, width), np.uint8)
    for row in range(table.shape[0]):
        for column in range(table.shape[1]):
            fits[BLOCK + row, BLOCK + column] = table[row, column, FITS]
            clashes[BLOCK + row, BLOCK + column] = table[row, column, CLASHES]
    for level in range(LEVELS):
        reach = 1 << level
        for row in range(height):
            for column in range(width):
                levels[level, row, 2 * column + FITS] = fits[row, column]
                levels[level, row, 2 * column + CLASHES] = clashes[row, column]
        for row in range(height):
            if row + reach < height:
                for column in range(width):
                    fits[row, column] = max(fits[row, column], fits[row + reach, column])
                    clashes[row, column] = min(clashes[row, column], clashes[row + reach, column])
            for column in range(width - reach):
                fits[row, column] = max(fits[row, column], fits[row, column + reach])
                clashes[row, column] = min(clashes[row, column], clashes[row, column + reach])
    for row in range(height):
        for first in range(BLOCK):
            values = phases[row % BLOCK, first, row // BLOCK]
            for block in range(width // BLOCK):
                values[2 * block + FITS] = fits[row, block * BLOCK + first]
                values[2 * block + CLASHES] = clashes[row, block * BLOCK + first]


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
def leave_out(turns_rad: np.ndarray, factor: np.ndarray, half: int, sums: np.ndarray) -> None:
    """Clear the FITS of blocks without a shift that `Blocks.factor` allows. ``sums``: as in `block_sums`."""
    to_middle, reach = 0.5 * (BLOCK - 1), 0.0
    for sign in (-1.0, 1.0):
        reach = max(reach, to_middle * np.sqrt(((factor[:, 0] + sign * factor[:, 1]) ** 2).sum()))
    for a in range(sums.shape[0]):
        for row in range(sums.shape[1]):
            for column in range(sums.shape[1]):
                x, y, square = BLOCK * column - half + to_middle, BLOCK * row - half + to_middle, 0.0
                for k in range(3):
                    square += (factor[k, 0] * x + factor[k, 1] * y + factor[k, 2] * turns_rad[a]) ** 2
                if np.sqrt(square) > 1.0 + reach:
                    sums[a, row, 2 * column + FITS] = 0


@njit(cache=True, nogil=True)
def _quarter_sums(
    level: np.ndarray, cells: np.ndarray, dx: int, dy: int, side: int, sums: np.ndarray
) -> None:
    """Sum the values at the points (n, 2) for the quarters of a square of shifts that begins at dx, dy.

    ``level`` is that of the quarters, which are ``side`` wide. ``sums`` (4, 2) gets FITS and CLASHES.
    """
    height, width = level.shape[0], level.shape[1] // 2
    values = level.reshape(-1)
    right, below = np.uint64(2 * side), np.uint64(2 * side * width)
    fits_0 = fits_1 = fits_2 = fits_3 = clashes_0 = clashes_1 = clashes_2 = clashes_3 = 0
    for i in range(cells.shape[0]):
        x, y = cells[i, 0] + dx + BLOCK, cells[i, 1] + dy + BLOCK
        if 0 <= x < width - BLOCK and 0 <= y < height - BLOCK:
            first = np.uint64(2 * (y * width + x))
            fits_0 += values[first]
            clashes_0 += values[first + np.uint64(CLASHES)]
            fits_1 += values[first + right]
            clashes_1 += values[first + right + np.uint64(CLASHES)]
            first += below
            fits_2 += values[first]
            clashes_2 += values[first + np.uint64(CLASHES)]
            fits_3 += values[first + right]
            clashes_3 += values[first + right + np.uint64(CLASHES)]
    sums[0, FITS], sums[1, FITS], sums[2, FITS], sums[3, FITS] = fits_0, fits_1, fits_2, fits_3
    sums[0, CLASHES], sums[1, CLASHES], sums[2, CLASHES], sums[3, CLASHES] = (
        clashes_0,
        clashes_1,
        clashes_2,
        clashes_3,
    )


@njit(cache=True, nogil=True)
def _clashes_back(
    table: np.ndarray, points_xy: np.ndarray, x: float, y: float, cos: float, sin: float, most: float
) -> float:
    """Clashes of the reference's points (n, 2) with the query's table, when the query stands at x, y, angle.

    Everything in cells; the query's table has its corner where its cell [0, 0] lies in the query's frame. The
    sum ends once it is greater than ``most``.
    """
    height, width = table.shape[:2]
    clashes = 0
    for i in range(points_xy.shape[0]):
        from_x, from_y = points_xy[i, 0] - x, points_xy[i, 1] - y
        column = int(np.floor(cos * from_x + sin * from_y))
        row = int(np.floor(-sin * from_x + cos * from_y))
        if 0 <= column < width and 0 <= row < height:
            clashes += table[row, column, CLASHES]
            if clashes > most:
                break
    return clashes / FULL


@njit(cache=True, nogil=True, inline="always")
def _is_allowed(factor: np.ndarray, dx: int, dy: int, turn: float) -> bool:
    square = 0.0
    for row in range(3):
        square += (factor[row, 0] * dx + factor[row, 1] * dy + factor[row, 2] * turn) ** 2
    return square <= 1.0


@njit(cache=True, nogil=True)
def best_shift(
    blocks: Blocks, reference: Reference, query: Query, circle: np.ndarray, floor: float, is_any: bool
) -> tuple[float, int, int, int]:
    """Search blocks by falling bound; return score, angle's index, dx and dy (cells) of the best shift.

    Args:
        blocks: the shifts to search.
        reference: the map that stays.
        query: the map that is shifted.
        circle: (3,) dx, dy and radius; shifts inside are left out.
        floor: least score of interest. If none is better, floor is returned as the score.
        is_any: the first shift that is found to be better than the floor is good enough.
    """
    half, least, cells = blocks.half, blocks.least, query.cells
    side = blocks.bounds.shape[1]
    best, best_a, best_dx, best_dy = floor, 0, 0, 0
    flat = blocks.bounds.reshape(-1)
    sums = np.empty((4, 2), np.int64)
    squares, bounds = np.empty((STACK, 3), np.int64), np.empty(STACK)
    for index in blocks.order:
        if flat[index] <= best:
            break
        a, rest = index // (side * side), index % (side * side)
        cos, sin = np.cos(query.angles_rad[a]), np.sin(query.angles_rad[a])
        squares[0] = (rest % side) * BLOCK - half, (rest // side) * BLOCK - half, LEVELS
        bounds[0], waiting = flat[index], 1
        while waiting:
            waiting -= 1
            x0, y0, level = squares[waiting, 0], squares[waiting, 1], squares[waiting, 2] - 1
            if bounds[waiting] <= best:
                continue
            _quarter_sums(reference.levels[level], cells[a], x0, y0, 1 << level, sums)
            for quarter in range(4):
                dx, dy = x0 + ((quarter & 1) << level), y0 + ((quarter >> 1) << level)
                fits, clashes = sums[quarter, FITS] / FULL, sums[quarter, CLASHES] / FULL
                bound = fits / max(fits + clashes, least)
                if dx > half or dy > half or bound <= best:
                    continue
                if level > 0:
                    squares[waiting, 0], squares[waiting, 1], squares[waiting, 2] = dx, dy, level
                    bounds[waiting] = bound
                    waiting += 1
                    continue
                is_near = (dx - circle[0]) ** 2 + (dy - circle[1]) ** 2 < circle[2] ** 2
                if is_near or not _is_allowed(blocks.factor, dx, dy, blocks.turns_rad[a]):
                    continue
                x, y = query.corners_xy[a, 0] + dx, query.corners_xy[a, 1] + dy
                # With one more clash than this the score cannot be the best.
                most = FULL * (fits / best - fits - clashes) + 1.0 if best > 0.0 else np.inf
                clashes += _clashes_back(query.table, reference.points_xy, x, y, cos, sin, most)
                score = fits / max(fits + clashes, least)
                if score > best:
                    best, best_a, best_dx, best_dy = score, a, dx, dy
                    if is_any:
                        return best, best_a, best_dx, best_dy
    return best, best_a, best_dx, best_dy
