"""Where a scan's beams run through the cells, and what that changes in a particle's tiles.

A beam is a line from the lidar's cell to the cell of its end. Along its major axis every cell column is met
once, at the row in which the line crosses the column's middle; the row is a closed form of the column, so
that the tiles which a beam will touch are known without walking through its cells.
"""

from __future__ import annotations

import numpy as np
from numba import njit

SIDE_BITS = 5
SIDE = 1 << SIDE_BITS
"""Cells along a tile's side."""
MASK = SIDE - 1
HITS_SHIFT = 8
VISITS_MAX = (1 << HITS_SHIFT) - 1
"""A cell's count holds its hits in the upper half and its visits in the lower one."""
PARTS = 65536
"""Parts of a cell in which the means of its hits are kept."""
FULLNESS = 0.1
"""A cell that more than this share of its beams hit is occupied to the scan matcher."""
EMPTY = 0
"""Index of the tile in which nothing was ever seen."""


@njit(cache=True, nogil=True, inline="always")
def _row(column, x0, y0, slope, low, high):
    """Row in which the line crosses a column's middle; cells in the table have no negative coordinates."""
    y = y0 + (column + 0.5 - x0) * slope
    return int(min(max(y, low), high))


@njit(cache=True, nogil=True, inline="always")
def _line(x0, y0, x1, y1):
    """Return (steep, x0, y0, slope, low, high, first column, last column), the end's own column left out."""
    steep = abs(y1 - y0) > abs(x1 - x0)
    if steep:
        x0, y0, x1, y1 = y0, x0, y1, x1
    slope = (y1 - y0) / (x1 - x0) if x1 != x0 else 0.0
    start, end = int(x0), int(x1)
    first, last = (start, end - 1) if end > start else (end + 1, start)
    return steep, x0, y0, slope, min(y0, y1), max(y0, y1), first, last


@njit(cache=True, nogil=True)
def _own(table, row, column, stamp, references, stamps, free, free_count, counts, means, occupied):
    """Give a table a tile of its own at one place, a copy if others have it too; stamp it.

    Returns the tile and the number of free tiles left.
    """
    tile = table[row, column]
    if tile == EMPTY or references[tile] > 1:
        free_count -= 1
        own = free[free_count]
        counts[own] = counts[tile]
        means[own] = means[tile]
        occupied[own] = occupied[tile]
        references[own] = 1
        if tile != EMPTY:
            references[tile] -= 1
        table[row, column] = own
        tile = own
    stamps[tile] = stamp
    return tile, free_count


@njit(cache=True, nogil=True)
def _recount(counts, occupied, tile, cell, hit):
    """Count a beam in a cell that was hit, or whose count would overflow; return the cell's hits."""
    hits = np.int64(counts[tile, cell] >> HITS_SHIFT) + hit
    visits = np.int64(counts[tile, cell] & VISITS_MAX) + 1
    if visits > VISITS_MAX:
        hits, visits = (hits + 1) >> 1, visits >> 1
    counts[tile, cell] = (hits << HITS_SHIFT) | visits
    row, bit = cell >> SIDE_BITS, np.int64(1) << (cell & MASK)
    others = np.int64(occupied[tile, row]) & ~bit
    occupied[tile, row] = others | bit if hits > FULLNESS * visits else others
    return hits


@njit(cache=True, nogil=True, inline="always")
def _moved(mean, value, number):
    """Return a mean of ``number`` values, in parts of a cell, of which the last is new."""
    old = np.float64(mean)
    return np.uint16(min(old + (value * PARTS - old) / number + 0.5, PARTS - 1.0))


@njit(cache=True, nogil=True)
def _insert_beam(
    table, lidar, end, hit, stamp, references, stamps, free, free_count, counts, means, occupied
):
    """Enter one beam into a particle's map; return the number of free tiles left.

    A tile that has the ``stamp`` of this insertion is the particle's own.
    """
    steep, x0, y0, slope, low, high, first, last = _line(lidar[0], lidar[1], end[0], end[1])
    along, across = (SIDE, 1) if steep else (1, SIDE)
    column = first
    while column <= last:
        stop = min(column | MASK, last)
        major = column >> SIDE_BITS
        near = _row(column, x0, y0, slope, low, high) >> SIDE_BITS
        far = _row(stop, x0, y0, slope, low, high) >> SIDE_BITS
        y, x = (major, near) if steep else (near, major)
        near_tile = table[y, x]
        if stamps[near_tile] != stamp:
            near_tile, free_count = _own(
                table, y, x, stamp, references, stamps, free, free_count, counts, means, occupied
            )
        y, x = (major, far) if steep else (far, major)
        far_tile = table[y, x]
        if stamps[far_tile] != stamp:
            far_tile, free_count = _own(
                table, y, x, stamp, references, stamps, free, free_count, counts, means, occupied
            )
        for c in range(column, stop + 1):
            row = _row(c, x0, y0, slope, low, high)
            tile = np.uint64(near_tile if row >> SIDE_BITS == near else far_tile)
            cell = np.uint64((c & MASK) * along + (row & MASK) * across)
            count = counts[tile, cell] + np.uint32(1)
            if count <= VISITS_MAX:
                counts[tile, cell] = count
            else:
                _recount(counts, occupied, tile, cell, 0)
        column = stop + 1
    if hit:
        x, y = int(end[0]), int(end[1])
        own = table[y >> SIDE_BITS, x >> SIDE_BITS]
        if stamps[own] != stamp:
            y_tile, x_tile = y >> SIDE_BITS, x >> SIDE_BITS
            own, free_count = _own(
                table, y_tile, x_tile, stamp, references, stamps, free, free_count, counts, means, occupied
            )
        cell = (y & MASK) * SIDE + (x & MASK)
        number = _recount(counts, occupied, own, cell, 1)
        means[own, cell, 0] = _moved(means[own, cell, 0], end[0] - x, number)
        means[own, cell, 1] = _moved(means[own, cell, 1], end[1] - y, number)
    return free_count


@njit(cache=True, nogil=True)
def place(pose, points, placed):
    """Write points (n, 2), given in the frame of a pose (3,), where the pose puts them."""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    for i in range(points.shape[0]):
        placed[i, 0] = pose[0] + cos * points[i, 0] - sin * points[i, 1]
        placed[i, 1] = pose[1] + sin * points[i, 0] + cos * points[i, 1]


@njit(cache=True, nogil=True)
def insert_scan(
    particle,
    beam,
    tables,
    poses,
    points,
    hits,
    placed,
    stamp,
    references,
    stamps,
    free,
    free_count,
    counts,
    means,
    occupied,
):
    """Enter a scan into the maps of all particles from ``particle`` on, beginning with one of its beams.

    Cells crossed are visited, the end's cell is also hit. ``points`` (n + 1, 2) are the lidar and the beams'
    ends in the base frame, in cells; hits (n,) says which beams end at something; ``placed`` (n + 1, 2) is
    scratch. ``stamp`` + p marks what particle p has written. ``free`` is a stack of ``free_count`` unused
    tiles.

    Returns (particle, beam, free_count): where free tiles may not suffice to go on, or (particles, 0, left).
    """
    need = 2 * (tables.shape[1] + tables.shape[2]) + 4
    for p in range(particle, tables.shape[0]):
        place(poses[p], points, placed)
        for i in range(beam, hits.size):
            if free_count < need:
                return p, i, free_count
            free_count = _insert_beam(
                tables[p],
                placed[0],
                placed[i + 1],
                hits[i],
                stamp + p,
                references,
                stamps,
                free,
                free_count,
                counts,
                means,
                occupied,
            )
        beam = 0
    return tables.shape[0], 0, free_count
