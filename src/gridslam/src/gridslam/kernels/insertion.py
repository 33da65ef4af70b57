"""What a scan changes in a particle's tiles.

A beam is a line from the lidar's cell to the cell of its end. Along its major axis every cell column is met
once, at the row in which the line crosses the column's middle. Beams are first counted on a board, which is
then added to the tiles: so a tile is looked up once for all beams that cross it.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from gridslam.kernels.board import (
    WORD_BITS,
    add,
    clear,
    count_beam,
    counted,
    is_crossed,
    parts_of,
    tiles_around,
)
from gridslam.kernels.tiles import (
    COUNT_MAX,
    EMPTY,
    FULLNESS,
    MASK,
    PARTS,
    SIDE,
    SIDE_BITS,
    own_ends,
    own_tile,
)


@njit(cache=True, nogil=True)
def place(pose, points, placed):
    """Write points (n, 2), given in the frame of a pose (3,), where the pose puts them."""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    for i in range(points.shape[0]):
        placed[i, 0] = pose[0] + cos * points[i, 0] - sin * points[i, 1]
        placed[i, 1] = pose[1] + sin * points[i, 0] + cos * points[i, 1]


@njit(cache=True, nogil=True, inline="always")
def _count(tile, cell, more_visits, more_hits, visits, occupied, entry, hits):
    """Add to a cell's counts, halving them if they would overflow; keep its bit; return its hits."""
    met = np.int64(visits[tile, cell]) + more_visits
    ended = np.int64(hits[entry, cell]) + more_hits
    while met > COUNT_MAX:
        met, ended = met >> 1, (ended + 1) >> 1
    visits[tile, cell] = met
    if entry != EMPTY:
        hits[entry, cell] = ended
    row, bit = cell >> SIDE_BITS, np.int64(1) << (cell & MASK)
    others = np.int64(occupied[tile, row]) & ~bit
    occupied[tile, row] = others | bit if ended > FULLNESS * met else others
    return ended


@njit(cache=True, nogil=True)
def _clear_bits(tile, words, stride, visits, occupied, entry, hits):
    """Clear the bits of cells that were counted and that too few of their beams have hit."""
    for row in range(SIDE):
        if occupied[tile, row] == 0:
            continue
        bits = np.int64(occupied[tile, row]) & np.int64(counted(words, row * stride))
        cell = row * SIDE
        while bits:
            if bits & 1 and hits[entry, cell] <= FULLNESS * visits[tile, cell]:
                occupied[tile, row] &= ~(np.uint32(1) << np.uint32(cell & MASK))
            bits >>= 1
            cell += 1


@njit(cache=True, nogil=True)
def _add_one_by_one(tile, board, at, stride, visits, occupied, entry, hits):
    """Add to a tile what was counted on its part of the board, where some count would overflow."""
    for row in range(SIDE):
        for column in range(SIDE):
            more = np.int64(board[at + row * stride + column])
            if more > 0:
                _count(tile, row * SIDE + column, more, 0, visits, occupied, entry, hits)


@njit(cache=True, nogil=True, inline="always")
def _moved(mean, value, number):
    """Return a mean of ``number`` values, in parts of a cell, of which the last is new."""
    old = np.float64(mean)
    return np.uint16(min(old + (value * PARTS - old) / number + 0.5, PARTS - 1.0))


@njit(cache=True, nogil=True, inline="always")
def _hit(tile, x, y, end, visits, occupied, entry, hits, means):
    """Count a beam's end in its cell, and move the mean of the cell's hits."""
    cell = (y & MASK) * SIDE + (x & MASK)
    number = _count(tile, cell, 1, 1, visits, occupied, entry, hits)
    means[entry, cell, 0] = _moved(means[entry, cell, 0], end[0] - x, number)
    means[entry, cell, 1] = _moved(means[entry, cell, 1], end[1] - y, number)


@njit(cache=True, nogil=True)
def _add_board(
    table,
    stamp,
    box,
    stride,
    board,
    words,
    references,
    stamps,
    visits,
    occupied,
    ends,
    end_references,
    hits,
    means,
    free_tiles,
    free_ends,
    free,
):
    """Add what was counted on the board to the tiles of a box, and clear it."""
    left, low, right, high = box
    row_words = stride >> WORD_BITS
    for y in range(low, high + 1):
        for x in range(left, right + 1):
            at = (y - low) * SIDE * stride + (x - left) * SIDE
            part = words[at >> WORD_BITS :]
            if not is_crossed(part, row_words):
                continue
            tile = own_tile(
                table,
                y,
                x,
                stamp,
                references,
                stamps,
                visits,
                occupied,
                ends,
                end_references,
                free_tiles,
                free,
            )
            if not add(part, row_words, visits[tile].view(np.uint64)):
                if ends[tile] != EMPTY:  # hits are about to be halved
                    own_ends(tile, ends, end_references, hits, means, free_ends, free)
                _add_one_by_one(tile, board, at, stride, visits, occupied, ends[tile], hits)
            if ends[tile] != EMPTY:
                _clear_bits(tile, part, row_words, visits, occupied, ends[tile], hits)
            clear(part, row_words)


@njit(cache=True, nogil=True)
def _insert_beams(
    table,
    stamp,
    box,
    lidar,
    points,
    are_hits,
    board,
    words,
    references,
    stamps,
    visits,
    occupied,
    ends,
    end_references,
    hits,
    means,
    free_tiles,
    free_ends,
    free,
):
    """Enter beams, which end at points (n, 2), into one particle's map."""
    left, low, right, _ = box
    stride = (right - left + 1) * SIDE
    origin = low * SIDE * stride + left * SIDE
    home = int(lidar[1]) * stride + int(lidar[0]) - origin
    at_home, parts = 0, parts_of(lidar, points)
    for part in range(parts):
        for i in range(part, points.shape[0], parts):
            at_home += count_beam(lidar, points[i], board, stride, origin, home)
        _add_board(
            table,
            stamp,
            box,
            stride,
            board,
            words,
            references,
            stamps,
            visits,
            occupied,
            ends,
            end_references,
            hits,
            means,
            free_tiles,
            free_ends,
            free,
        )
    if at_home:
        x, y = int(lidar[0]), int(lidar[1])
        tile = own_tile(
            table,
            y >> SIDE_BITS,
            x >> SIDE_BITS,
            stamp,
            references,
            stamps,
            visits,
            occupied,
            ends,
            end_references,
            free_tiles,
            free,
        )
        if ends[tile] != EMPTY:  # hits may be halved
            own_ends(tile, ends, end_references, hits, means, free_ends, free)
        _count(tile, (y & MASK) * SIDE + (x & MASK), at_home, 0, visits, occupied, ends[tile], hits)
    for i in range(points.shape[0]):
        if are_hits[i]:
            x, y = int(points[i, 0]), int(points[i, 1])
            tile = table[y >> SIDE_BITS, x >> SIDE_BITS]
            if stamps[tile] != stamp:
                tile = own_tile(
                    table,
                    y >> SIDE_BITS,
                    x >> SIDE_BITS,
                    stamp,
                    references,
                    stamps,
                    visits,
                    occupied,
                    ends,
                    end_references,
                    free_tiles,
                    free,
                )
            entry = ends[tile]
            if entry == EMPTY or end_references[entry] > 1:
                entry = own_ends(tile, ends, end_references, hits, means, free_ends, free)
            _hit(tile, x, y, points[i], visits, occupied, entry, hits, means)


@njit(cache=True, nogil=True)
def insert_scan(
    particle,
    tables,
    poses,
    points,
    are_hits,
    placed,
    stamp,
    board,
    references,
    stamps,
    visits,
    occupied,
    ends,
    end_references,
    hits,
    means,
    free_tiles,
    free_ends,
    free,
):
    """Enter a scan into the maps of all particles from ``particle`` on.

    Cells crossed are visited, the end's cell is also hit. ``points`` (n + 1, 2) are the lidar and the beams'
    ends in the base frame, in cells; are_hits (n,) says which beams end at something; ``placed`` (n + 1, 2)
    is scratch, and so is ``board``, which must be 0 and will be. ``stamp`` + p marks what particle p has
    written. The rest are the arrays of `Tiles`.

    Returns the particle with which to go on where free tiles or ends may not suffice, or their number.
    """
    words = board.view(np.uint64)
    for p in range(particle, tables.shape[0]):
        place(poses[p], points, placed)
        box = tiles_around(placed[0], placed[1:])
        if free.min() < (box[2] - box[0] + 1) * (box[3] - box[1] + 1):
            return p
        _insert_beams(
            tables[p],
            stamp + p,
            box,
            placed[0],
            placed[1:],
            are_hits,
            board,
            words,
            references,
            stamps,
            visits,
            occupied,
            ends,
            end_references,
            hits,
            means,
            free_tiles,
            free_ends,
            free,
        )
    return tables.shape[0]
