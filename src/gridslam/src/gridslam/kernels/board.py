"""The board on which the beams of a scan are counted, before the counts go to a particle's tiles.

It has one byte for each cell around the beams, row by row. A tile adds its part of the board in words of
eight cells.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from gridslam.kernels.tiles import COUNT_MAX, SIDE, SIDE_BITS

ROW_BITS = 32
ROW = float(1 << ROW_BITS)
"""Unit of the row along a beam: this fraction of a cell, in fixed-point numbers."""
WORD_BITS = 3
"""A word holds 2 to the power of this many cells."""
ROW_WORDS = SIDE >> WORD_BITS
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
    lidar: np.ndarray, end: np.ndarray, board: np.ndarray, stride: int, origin: int, home: int
) -> bool:
    """Count a beam in the cells from the lidar's on to the one before its end's.

    ``board`` (cells,) uint8 has cell x, y at y * stride + x - origin. Nearly every beam begins in ``home``,
    the lidar's own cell, which is not counted here. The return value says whether the beam counts there.
    """
    steep = abs(end[1] - lidar[1]) > abs(end[0] - lidar[0])
    if steep:
        x0, y0, x1, y1, along, across = lidar[1], lidar[0], end[1], end[0], stride, 1
    else:
        x0, y0, x1, y1, along, across = lidar[0], lidar[1], end[0], end[1], 1, stride
    start, stop = int(x0), int(x1)
    if start == stop:
        return False
    slope = (y1 - y0) / (x1 - x0)
    # The middle of the lidar's own column may lie behind the lidar.
    row = int(min(max(y0 + (start + 0.5 - x0) * slope, min(y0, y1)), max(y0, y1)))
    begin = start * along + row * across - origin
    if begin != home:
        board[np.uint64(begin)] += np.uint8(1)
    first, last = (start + 1, stop - 1) if stop > start else (stop + 1, start - 1)
    fixed, step = np.int64((y0 + (first + 0.5 - x0) * slope) * ROW), np.int64(slope * ROW)
    cell = first * along - origin
    if steep:  # two loops, to save a multiplication by one
        for _ in range(last - first + 1):
            board[np.uint64(cell + (fixed >> ROW_BITS))] += np.uint8(1)
            fixed += step
            cell += stride
    else:
        for _ in range(last - first + 1):
            board[np.uint64(cell + (fixed >> ROW_BITS) * stride)] += np.uint8(1)
            fixed += step
            cell += 1
    return begin == home


@njit(cache=True, nogil=True, inline="always")
def is_crossed(words: np.ndarray, stride: int) -> bool:
    """Return whether any of a tile's cells on the board was counted."""
    for row in range(SIDE):
        counted = np.uint64(0)
        for word in range(ROW_WORDS):
            counted |= words[row * stride + word]
        if counted:
            return True
    return False


@njit(cache=True, nogil=True, inline="always")
def counted(words: np.ndarray, first: int) -> np.uint64:
    """Return bits of a row's counted cells."""
    bits = np.uint64(0)
    for word in range(ROW_WORDS):
        more = words[first + word]
        # the top bit of each nonzero byte; the product collects them in its top byte
        tops = ((((more & SEVEN_BITS) + SEVEN_BITS) | more) & TOP_BITS) >> np.uint64(7)
        bits |= ((tops * GATHER) >> np.uint64(56)) << np.uint64(word << WORD_BITS)
    return bits


@njit(cache=True, nogil=True)
def add(words: np.ndarray, stride: int, cells: np.ndarray) -> bool:
    """Add eight cells at a time to those of a tile. If one would overflow, add nothing and return False."""
    carried = np.uint64(0)
    for row in range(SIDE):
        for word in range(ROW_WORDS):
            more, old = words[row * stride + word], cells[row * ROW_WORDS + word]
            total = old + more
            cells[row * ROW_WORDS + word] = total
            carried |= (old & more) | ((old | more) & ~total)
    if carried & TOP_BITS == 0:
        return True
    for row in range(SIDE):
        for word in range(ROW_WORDS):
            cells[row * ROW_WORDS + word] -= words[row * stride + word]
    return False


@njit(cache=True, nogil=True)
def clear(words: np.ndarray, stride: int) -> None:
    """Clear a tile's part of the board."""
    for row in range(SIDE):
        for word in range(ROW_WORDS):
            words[row * stride + word] = 0
