"""The board on which the beams of a scan are counted, before the counts go to a particle's tiles.

It has one byte for each cell around the beams: tile by tile, and row by row in a tile. So a tile's part is as
contiguous as the tile itself, and is added in words of eight cells.
"""

from __future__ import annotations

import numpy as np

from gridslam.kernels.tiles import COUNT_MAX, MASK, SIDE, SIDE_BITS
from kernel_cache.compiler import njit

ROW_BITS = 32
ROW = float(1 << ROW_BITS)
"""Unit of the row along a beam: this fraction of a cell, in fixed-point numbers."""
WORD_BITS = 3
"""A word holds 2 to the power of this many cells."""
ROW_WORDS = SIDE >> WORD_BITS
CELL_BITS = 2 * SIDE_BITS
"""A tile holds 2 to the power of this many cells."""
WORDS = 1 << (CELL_BITS - WORD_BITS)
"""A tile's words."""
SEVEN_BITS = np.uint64(0x7F7F7F7F7F7F7F7F)
TOP_BITS = np.uint64(0x8080808080808080)
GATHER = np.uint64(0x0102040810204080)
ONE = np.uint8(1)
# An index without a sign needs no test whether it counts from the end of the array.
TILE_BITS = np.uint64(ROW_BITS + SIDE_BITS)
FLAT_SHIFT, STEEP_SHIFT = np.uint64(ROW_BITS - SIDE_BITS), np.uint64(ROW_BITS)
FLAT_MASK, STEEP_MASK = np.uint64(MASK << SIDE_BITS), np.uint64(MASK)
FLAT_ONWARD, STEEP_ONWARD = np.uint64(1), np.uint64(SIDE)


@njit(cache=True, nogil=True)
def tiles_around(lidar: np.ndarray, ends: np.ndarray) -> tuple[int, int, int, int]:
    """Return the tiles (first x, first y, last x, last y) that hold beams, with a margin of one cell."""
    low_x, low_y, high_x, high_y = lidar[0], lidar[1], lidar[0], lidar[1]
    for i in range(ends.shape[0]):
        low_x, high_x = min(low_x, ends[i, 0]), max(high_x, ends[i, 0])
        low_y, high_y = min(low_y, ends[i, 1]), max(high_y, ends[i, 1])
    first_x, first_y = (int(low_x) - 1) >> SIDE_BITS, (int(low_y) - 1) >> SIDE_BITS
    return first_x, first_y, (int(high_x) + 1) >> SIDE_BITS, (int(high_y) + 1) >> SIDE_BITS


@njit(cache=True, nogil=True)
def _most_in_neighbours(lidar: np.ndarray, ends: np.ndarray, parts: int) -> int:
    """Return the greatest number of beams in two neighbouring sectors, counting every ``parts``-th beam."""
    most = 0
    for part in range(parts):
        right, up, left, down = 0, 0, 0, 0
        for i in range(part, ends.shape[0], parts):
            x, y = ends[i, 0] - lidar[0], ends[i, 1] - lidar[1]
            if abs(y) > abs(x):
                up, down = up + (y > 0.0), down + (y < 0.0)
            else:
                right, left = right + (x > 0.0), left + (x < 0.0)
        most = max(most, max(right, left) + max(up, down))
    return most


@njit(cache=True, nogil=True)
def parts_of(lidar: np.ndarray, ends: np.ndarray) -> int:
    """Return the number of parts in which beams must be counted, so that no count overflows.

    Part k holds every n-th beam from the k-th on. A sector is a quarter turn around an axis, up to the
    diagonals. A cell other than the lidar's own meets only beams of one sector, or of two neighbouring ones.
    """
    parts, most = 1, _most_in_neighbours(lidar, ends, 1)
    while most > COUNT_MAX:
        parts = max(parts + 1, most * parts // COUNT_MAX)
        most = _most_in_neighbours(lidar, ends, parts)
    return parts


@njit(cache=True, nogil=True, inline="always")
def _count_run(
    board: np.ndarray,
    here: np.uint64,
    there: np.uint64,
    at: np.uint64,
    step: np.uint64,
    cells: int,
    shift: np.uint64,
    mask: np.uint64,
    onward: np.uint64,
) -> np.uint64:
    """Count a beam in one cell of each of some columns of a tile. Return its row in the next column.

    ``at`` is the row in the first column, in fixed point; it grows by ``step``. ``here`` is the place of
    that column's first cell on the board. ``there`` is the same in the tile of the last column's row. Both
    grow by ``onward``. ``shift`` and ``mask`` make a row's place in a tile from ``at``.
    """
    if here == there:
        for _ in range(cells):
            board[here | at >> shift & mask] += ONE
            here += onward
            at += step
        return at
    row_tile = at >> TILE_BITS
    for _ in range(cells):
        board[(here if at >> TILE_BITS == row_tile else there) | at >> shift & mask] += ONE
        here += onward
        there += onward
        at += step
    return at


@njit(cache=True, nogil=True, inline="always")
def count_beam(
    lidar: np.ndarray,
    end: np.ndarray,
    board: np.ndarray,
    are_wanted: np.ndarray,
    are_crossed: np.ndarray,
    are_passed: np.ndarray,
    width: int,
    left: int,
    low: int,
) -> bool:
    """Count a beam in the cells from the lidar's on to the one before its end's.

    ``board`` (cells,) uint8 is ``width`` tiles wide; its corner is the cell left, low. Tiles that are not
    wanted (tiles,) are left out, as a rule. ``are_crossed`` (tiles,) takes which tiles hold a counted cell,
    and ``are_passed`` (tiles,) which others the beam crosses.
    Nearly every beam begins in the lidar's own cell, which is not counted here. The return value says whether
    the beam counts there.
    """
    steep = abs(end[1] - lidar[1]) > abs(end[0] - lidar[0])
    if steep:
        x0, y0, x1, y1, first_x, first_y = lidar[1], lidar[0], end[1], end[0], low, left
    else:
        x0, y0, x1, y1, first_x, first_y = lidar[0], lidar[1], end[0], end[1], left, low
    start, stop = int(x0), int(x1)
    if start == stop:
        return False
    slope = (y1 - y0) / (x1 - x0)
    # The middle of the lidar's own column may lie behind the lidar.
    row = int(min(max(y0 + (start + 0.5 - x0) * slope, min(y0, y1)), max(y0, y1)))
    is_home = row == int(y0)
    if not is_home:
        x, y = (row - first_y, start - first_x) if steep else (start - first_x, row - first_y)
        tile = (y >> SIDE_BITS) * width + (x >> SIDE_BITS)
        board[tile << CELL_BITS | (y & MASK) << SIDE_BITS | x & MASK] += ONE
        are_crossed[tile] = True
    first, last = (start + 1, stop - 1) if stop > start else (stop + 1, start - 1)
    fixed = np.int64((y0 + (first + 0.5 - x0) * slope) * ROW) - (np.int64(first_y) << ROW_BITS)
    at, step = np.uint64(fixed), np.uint64(np.int64(slope * ROW))
    column, last = first - first_x, last - first_x
    row_tiles, column_tiles, column_bits = (1, width, SIDE_BITS) if steep else (width, 1, 0)
    while column <= last:  # tile by tile along the major axis, in which the beam meets one or two tiles
        cells = min(last, column | MASK) - column + 1
        tile, in_tile = (column >> SIDE_BITS) * column_tiles, (column & MASK) << column_bits
        here = tile + np.int64(at >> TILE_BITS) * row_tiles
        there = tile + np.int64(at + np.uint64(cells - 1) * step >> TILE_BITS) * row_tiles
        if not (are_wanted[here] or are_wanted[there]):
            are_passed[here], are_passed[there] = True, True
            at += np.uint64(cells) * step
            column += cells
            continue
        are_crossed[here], are_crossed[there] = True, True
        a, b = np.uint64(here << CELL_BITS | in_tile), np.uint64(there << CELL_BITS | in_tile)
        if steep:
            at = _count_run(board, a, b, at, step, cells, STEEP_SHIFT, STEEP_MASK, STEEP_ONWARD)
        else:
            at = _count_run(board, a, b, at, step, cells, FLAT_SHIFT, FLAT_MASK, FLAT_ONWARD)
        column += cells
    return is_home


@njit(cache=True, nogil=True)
def count_in_tile(
    lidar: np.ndarray, end: np.ndarray, tile_x: int, tile_y: int, part: np.ndarray
) -> tuple[bool, bool]:
    """Count a beam as `count_beam` does, but in one tile only, whose ``part`` (cells,) this is.

    Returns whether a cell was counted, and what `count_beam` returns.
    """
    steep = abs(end[1] - lidar[1]) > abs(end[0] - lidar[0])
    if steep:
        x0, y0, x1, y1, tile_x, tile_y = lidar[1], lidar[0], end[1], end[0], tile_y, tile_x
    else:
        x0, y0, x1, y1 = lidar[0], lidar[1], end[0], end[1]
    start, stop = int(x0), int(x1)
    if start == stop:
        return False, False
    onward, across = (SIDE, 1) if steep else (1, SIDE)
    slope, is_counted = (y1 - y0) / (x1 - x0), False
    row = int(min(max(y0 + (start + 0.5 - x0) * slope, min(y0, y1)), max(y0, y1)))
    is_home = row == int(y0)
    if not is_home and start >> SIDE_BITS == tile_x and row >> SIDE_BITS == tile_y:
        part[(start & MASK) * onward + (row & MASK) * across] += ONE
        is_counted = True
    first, last = (start + 1, stop - 1) if stop > start else (stop + 1, start - 1)
    low, high = max(first, tile_x << SIDE_BITS), min(last, tile_x << SIDE_BITS | MASK)
    at, step = np.int64((y0 + (first + 0.5 - x0) * slope) * ROW), np.int64(slope * ROW)
    at += (low - first) * step
    for column in range(low, high + 1):
        if at >> (ROW_BITS + SIDE_BITS) == tile_y:
            part[(column & MASK) * onward + ((at >> ROW_BITS) & MASK) * across] += ONE
            is_counted = True
        at += step
    return is_counted, is_home


@njit(cache=True, nogil=True, inline="always")
def counted(words: np.ndarray, row: int) -> np.uint64:
    """Return bits of a row's counted cells."""
    bits = np.uint64(0)
    for word in range(ROW_WORDS):
        more = words[row * ROW_WORDS + word]
        # the top bit of each nonzero byte; the product collects them in its top byte
        tops = ((((more & SEVEN_BITS) + SEVEN_BITS) | more) & TOP_BITS) >> np.uint64(7)
        bits |= ((tops * GATHER) >> np.uint64(56)) << np.uint64(word << WORD_BITS)
    return bits


@njit(cache=True, nogil=True, inline="always")
def carries(old: np.uint64, more: np.uint64, total: np.uint64) -> np.uint64:
    """Return nonzero if one of the eight cells in ``total`` = ``old`` + ``more`` has overflown."""
    return ((old & more) | ((old | more) & ~total)) & TOP_BITS
