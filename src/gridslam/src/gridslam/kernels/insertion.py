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
HITS_SHIFT = 16
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


@njit(cache=True, nogil=True, inline="always")
def _mark(column, row, steep, seen, stamp, positions, count):
    """Append the tile of a cell to the positions unless it is there."""
    if steep:
        column, row = row, column
    tile_y, tile_x = row >> SIDE_BITS, column >> SIDE_BITS
    if seen[tile_y, tile_x] != stamp:
        seen[tile_y, tile_x] = stamp
        positions[count] = tile_y * seen.shape[1] + tile_x
        count += 1
    return count


@njit(cache=True, nogil=True)
def touched_tiles(lidar, ends, hits, seen, stamp, positions):
    """Collect the tiles that beams from ``lidar`` (2,) to ``ends`` (n, 2), in cells, will touch.

    ``seen`` (h, w) int32 is scratch without the value ``stamp``; ``positions`` (h * w) takes the tiles'
    places in the table, row by row. Returns their number.
    """
    count = 0
    for beam in range(ends.shape[0]):
        steep, x0, y0, slope, low, high, first, last = _line(lidar[0], lidar[1], ends[beam, 0], ends[beam, 1])
        column = first
        while column <= last:
            end = min(column | MASK, last)
            count = _mark(
                column, _row(column, x0, y0, slope, low, high), steep, seen, stamp, positions, count
            )
            count = _mark(column, _row(end, x0, y0, slope, low, high), steep, seen, stamp, positions, count)
            column = end + 1
        if hits[beam]:
            x, y = int(ends[beam, 0]), int(ends[beam, 1])
            count = _mark(x, y, False, seen, stamp, positions, count)
    return count


@njit(cache=True, nogil=True)
def _own_tiles(table, positions, count, references, stamps, stamp, free, free_count, counts, means, occupied):
    """Give one particle tiles of its own at the first ``count`` positions of its ``table``.

    ``free`` is a stack of ``free_count`` unused tiles, of which enough must be left. Returns what is left.
    """
    flat = table.reshape(-1)
    for i in range(count):
        position = positions[i]
        tile = flat[position]
        if tile == EMPTY or references[tile] > 1:
            free_count -= 1
            own = free[free_count]
            counts[own] = counts[tile]
            means[own] = means[tile]
            occupied[own] = occupied[tile]
            references[own] = 1
            if tile != EMPTY:
                references[tile] -= 1
            flat[position] = own
            tile = own
        stamps[tile] = stamp
    return free_count


@njit(cache=True, nogil=True)
def place(pose, points, placed):
    """Write points (n, 2), given in the frame of a pose (3,), where the pose puts them."""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    for i in range(points.shape[0]):
        placed[i, 0] = pose[0] + cos * points[i, 0] - sin * points[i, 1]
        placed[i, 1] = pose[1] + sin * points[i, 0] + cos * points[i, 1]


@njit(cache=True, nogil=True)
def own_tiles(
    first,
    tables,
    poses,
    beams,
    hits,
    placed,
    seen,
    positions,
    stamp,
    references,
    stamps,
    free,
    free_count,
    counts,
    means,
    occupied,
):
    """Give the particles from ``first`` on tiles of their own wherever their beams will write.

    ``beams`` (n + 1, 2) are the lidar and the beams' ends in the base frame. Returns the particle for
    which the free tiles do not suffice (or the number of particles) and the number of free tiles left.
    """
    for p in range(first, tables.shape[0]):
        place(poses[p], beams, placed)
        count = touched_tiles(placed[0], placed[1:], hits, seen, stamp + p, positions)
        if count > free_count:
            return p, free_count
        free_count = _own_tiles(
            tables[p],
            positions,
            count,
            references,
            stamps,
            stamp + p,
            free,
            free_count,
            counts,
            means,
            occupied,
        )
    return tables.shape[0], free_count


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
def insert(table, lidar, ends, hits, counts, means, occupied):
    """Enter beams into one particle's own tiles: cells crossed are visited, the end's cell is also hit.

    lidar (2,) and ends (n, 2) are in cells from the table's corner; hits (n,) says which beams end at
    something. A cell's mean is that of its hits, from the cell's corner.
    """
    for beam in range(ends.shape[0]):
        steep, x0, y0, slope, low, high, first, last = _line(lidar[0], lidar[1], ends[beam, 0], ends[beam, 1])
        along, across = (SIDE, 1) if steep else (1, SIDE)
        column = first
        while column <= last:
            end = min(column | MASK, last)
            near = _row(column, x0, y0, slope, low, high) >> SIDE_BITS
            far = _row(end, x0, y0, slope, low, high) >> SIDE_BITS
            major = column >> SIDE_BITS
            near_tile = table[major, near] if steep else table[near, major]
            far_tile = table[major, far] if steep else table[far, major]
            for c in range(column, end + 1):
                row = _row(c, x0, y0, slope, low, high)
                tile = np.uint64(near_tile if row >> SIDE_BITS == near else far_tile)
                cell = np.uint64((c & MASK) * along + (row & MASK) * across)
                count = counts[tile, cell] + np.uint32(1)
                if count <= VISITS_MAX:
                    counts[tile, cell] = count
                else:
                    _recount(counts, occupied, tile, cell, 0)
            column = end + 1
        if hits[beam]:
            x, y = int(ends[beam, 0]), int(ends[beam, 1])
            tile, cell = table[y >> SIDE_BITS, x >> SIDE_BITS], (y & MASK) * SIDE + (x & MASK)
            number = _recount(counts, occupied, tile, cell, 1)
            means[tile, cell, 0] = _moved(means[tile, cell, 0], ends[beam, 0] - x, number)
            means[tile, cell, 1] = _moved(means[tile, cell, 1], ends[beam, 1] - y, number)


@njit(cache=True, nogil=True)
def insert_scan(first, last, tables, poses, beams, hits, counts, means, occupied):
    """Enter a scan into the maps of particles first to last - 1, which own the tiles it writes into."""
    placed = np.empty_like(beams)
    for p in range(first, last):
        place(poses[p], beams, placed)
        insert(tables[p], placed[0], placed[1:], hits, counts, means, occupied)
