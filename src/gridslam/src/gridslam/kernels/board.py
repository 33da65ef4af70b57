"""The board on which the beams of a scan are counted, before the counts go to a particle's tiles.

It has one byte for each cell around the beams: tile by tile, and row by row in a tile. So a tile's part is as
contiguous as the tile itself, and is added in words of eight cells.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from gridslam.kernels.tiles import COUNT_MAX, MASK, SIDE, SIDE_BITS

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


@njit(cache=True, nogil=True)
def count_beam(
    lidar: np.ndarray,
    end: np.ndarray,
    board: np.ndarray,
    are_crossed: np.ndarray,
    width: int,
    left: int,
    low: int,
) -> bool:
    """Count a beam in the cells from the lidar's on to the one before its end's.

    ``board`` (cells,) uint8 is ``width`` tiles wide; its corner is the cell left, low. ``are_crossed``
    (tiles,) takes which tiles hold a counted cell. Nearly every beam begins in the lidar's own cell, which is
    not counted here. The return value says whether the beam counts there.
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
        board[tile << CELL_BITS | (y & MASK) << SIDE_BITS | x & MASK] += np.uint8(1)
        are_crossed[tile] = True
    first, last = (start + 1, stop - 1) if stop > start else (stop + 1, start - 1)
    fixed, step = np.int64((y0 + (first + 0.5 - x0) * slope) * ROW), np.int64(slope * ROW)
    fixed -= np.int64(first_y) << ROW_BITS
    column, last = first - first_x, last - first_x
    row_bits, column_bits = (0, SIDE_BITS) if steep else (SIDE_BITS, 0)
    row_tiles, column_tiles = (1, width) if steep else (width, 1)
    while column <= last:  # tile by tile along the major axis, in which the beam meets one or two tiles
        in_tile = min(last, column | MASK)
        tile = (column >> SIDE_BITS) * column_tiles
        for at in (fixed, fixed + (in_tile - column) * step):
            are_crossed[tile + (at >> ROW_BITS + SIDE_BITS) * row_tiles] = True
        place = tile << CELL_BITS | (column & MASK) << column_bits
        for _ in range(column, in_tile + 1):
            minor = fixed >> ROW_BITS
            across = (minor >> SIDE_BITS) * row_tiles << CELL_BITS | (minor & MASK) << row_bits
            board[np.uint64(place + across)] += np.uint8(1)
            fixed += step
            place += 1 << column_bits
        column = in_tile + 1
    return is_home


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
