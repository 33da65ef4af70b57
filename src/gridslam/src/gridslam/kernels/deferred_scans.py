"""Scans whose free space waits: it is entered when most particles that differ now have died out.

Scan matching looks only at tiles in which beams have ended. Into these a scan is entered at once. Other tiles
hold free space alone. They are entered several scans later, once for all particles that have the same
past. A tile whose content is needed before is settled: the scans that wait are entered into it alone.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gridslam.kernels.board import count_in_tile, parts_of, tiles_around
from gridslam.kernels.insertion import BeamEnds, add_at_home, add_part, enter_beams, insert_beams, place
from gridslam.kernels.tiles import EMPTY, SIDE, SIDE_BITS, TILES, Tiles, own_tiles
from kernel_cache.compiler import njit

LEFT_MAX = 64
"""A particle with more tiles of its own than this is not settled tile by tile, which would take longer."""
TILE_RADIUS = SIDE / np.sqrt(2.0) + 2.0
"""Cells: a beam that meets a cell of a tile is nearer to the tile's middle."""


class DeferredScans(NamedTuple):
    """The scans that wait. The first axis is the slot: that of scan n is n modulo the number of slots."""

    points: np.ndarray
    """(slots, most beams + 1, 2) the lidar and the beams' ends, in cells, in the base frame."""
    counts: np.ndarray
    """(slots,) number of these points."""
    reaches: np.ndarray
    """(slots,) cells: length of the longest beam."""
    poses: np.ndarray
    """(slots, particles, 3) in cells from the window's corner, as it was."""
    parts: np.ndarray
    """(slots, particles) what `parts_of` said."""
    corners: np.ndarray
    """(slots, 2) the window's corner, as it was, x and y in tiles."""
    numbers: np.ndarray
    """(2,) numbers of the first scan that waits, and of the next one to come."""
    settled: np.ndarray
    """(particles,) number of the last scan that is entered everywhere in a particle's map."""
    placed: np.ndarray
    """(most beams + 1, 2) scratch."""


@njit(cache=True, nogil=True)
def _count_near(
    middle: np.ndarray,
    tile_xy: tuple[int, int],
    pose: np.ndarray,
    points: np.ndarray,
    begin: int,
    step: int,
    part: np.ndarray,
) -> tuple[bool, int]:
    """Count every ``step``-th beam in one tile. Return whether a cell was counted, and the beams at home.

    ``middle`` (2,) is the tile's, in the base frame, from the lidar.
    """
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    placed = np.empty((2, 2))
    place(pose, points[:1], placed[:1])
    are_any, at_home, radius2 = False, 0, TILE_RADIUS**2
    for i in range(begin, points.shape[0], step):
        x, y = points[i, 0] - points[0, 0], points[i, 1] - points[0, 1]
        along, across = x * middle[0] + y * middle[1], x * middle[1] - y * middle[0]
        length2 = x * x + y * y
        if across * across > radius2 * length2 or (along < 0.0 and along * along > radius2 * length2):
            continue
        placed[1, 0] = pose[0] + cos * points[i, 0] - sin * points[i, 1]
        placed[1, 1] = pose[1] + sin * points[i, 0] + cos * points[i, 1]
        is_counted, is_home = count_in_tile(placed[0], placed[1], tile_xy[0], tile_xy[1], part)
        are_any |= is_counted
        at_home += is_home
    return are_any, at_home


@njit(cache=True, nogil=True)
def settle_place(
    particle: int,
    table: np.ndarray,
    row: int,
    column: int,
    corner: np.ndarray,
    until: int,
    stamp: int,
    deferred: DeferredScans,
    tiles: Tiles,
) -> None:
    """Enter into one tile of a particle's table the scans that wait, with numbers less than ``until``."""
    first = max(deferred.settled[particle], tiles.scans[table[row, column]]) + 1
    if first >= until:
        return
    part, is_own = np.zeros(SIDE * SIDE, np.uint8), np.ones(1, np.bool_)
    words, middle = part.view(np.uint64), np.empty(2)
    visits, box = tiles.visits.view(np.uint64).ravel(), (column, row, column, row)
    for number in range(first, until):
        slot = number % deferred.counts.size
        pose, points = deferred.poses[slot, particle], deferred.points[slot, : deferred.counts[slot]]
        tile_x, tile_y = (
            column + corner[0] - deferred.corners[slot, 0],
            row + corner[1] - deferred.corners[slot, 1],
        )
        x, y = (tile_x + 0.5) * SIDE - pose[0], (tile_y + 0.5) * SIDE - pose[1]
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        middle[0], middle[1] = cos * x + sin * y - points[0, 0], cos * y - sin * x - points[0, 1]
        if middle[0] ** 2 + middle[1] ** 2 > (deferred.reaches[slot] + TILE_RADIUS) ** 2:
            continue
        at_home, parts = np.int64(0), deferred.parts[slot, particle]
        for lot in range(parts):
            are_any, more = _count_near(middle, (tile_x, tile_y), pose, points, lot + 1, parts, part)
            if are_any:
                own_tiles(table, box, is_own, stamp, number, tiles)
                add_part(words, 0, visits, table[row, column], tiles)
            at_home += more
        if at_home:
            lidar = deferred.placed[0]
            place(pose, points[:1], deferred.placed[:1])
            x, y = int(lidar[0]), int(lidar[1])
            if x >> SIDE_BITS == tile_x and y >> SIDE_BITS == tile_y:
                own_tiles(table, box, is_own, stamp, number, tiles)
                x, y = x + (column - tile_x) * SIDE, y + (row - tile_y) * SIDE
                add_at_home(table, x, y, at_home, tiles)


@njit(cache=True, nogil=True)
def settle_places(
    particle: int,
    table: np.ndarray,
    places: np.ndarray,
    corner: np.ndarray,
    stamp: int,
    deferred: DeferredScans,
    tiles: Tiles,
) -> None:
    """Settle the tiles of a particle's table at places (n, 2), row and column."""
    for i in range(places.shape[0]):
        row, column = places[i]
        if tiles.ends[table[row, column]] == EMPTY:
            settle_place(particle, table, row, column, corner, deferred.numbers[1], stamp, deferred, tiles)


@njit(cache=True, nogil=True)
def insert_surfaces(
    particle: int,
    tables: np.ndarray,
    scan: BeamEnds,
    corner: np.ndarray,
    stamp: int,
    deferred: DeferredScans,
    tiles: Tiles,
) -> int:
    """Enter the next scan into the maps of all particles from ``particle`` on, but let free space wait.

    A beam visits the cells that it crosses, and also hits the cell of its end. ``tables`` (particles, h, w)
    are the particles' maps. ``stamp`` + p marks the tiles written by particle p. Returns the number of
    particles. If there may be too few free tiles or ends for a particle, it stops before that particle and
    returns its index.
    """
    number = deferred.numbers[1]
    slot = number % deferred.counts.size
    ends = tiles.ends
    for p in range(particle, tables.shape[0]):
        table, points = tables[p], scan.placed[1:]
        place(deferred.poses[slot, p], scan.points, scan.placed)
        box = tiles_around(scan.placed[0], points)
        width = box[2] - box[0] + 1
        area = width * (box[3] - box[1] + 1)
        if tiles.free.min() < area:
            return p
        at = 0
        for row in range(box[1], box[3] + 1):
            for column in range(box[0], box[2] + 1):
                scan.are_wanted[at] = ends[table[row, column]] != EMPTY
                at += 1
        for i in range(points.shape[0]):
            if scan.are_hits[i]:
                row, column = int(points[i, 1]) >> SIDE_BITS, int(points[i, 0]) >> SIDE_BITS
                at = (row - box[1]) * width + column - box[0]
                if not scan.are_wanted[at]:
                    scan.are_wanted[at] = True
                    settle_place(p, table, row, column, corner, number, stamp + p, deferred, tiles)
        deferred.parts[slot, p] = parts_of(scan.placed[0], points)
        insert_beams(table, stamp + p, number, box, deferred.parts[slot, p], scan, tiles)
    return tables.shape[0]


@njit(cache=True, nogil=True)
def _share(
    table: np.ndarray,
    other: np.ndarray,
    places: np.ndarray,
    before: np.ndarray,
    number: int,
    left: np.ndarray,
    tiles: Tiles,
) -> int:
    """Where another table had the tiles that a table had before, give it those that the table has now.

    ``before`` (n,) are the tiles at ``places`` (n, 2), row and column. Writes into ``left`` the places of the
    free tiles that the other table has for itself, and into which the scan is not entered. Returns their
    number.
    """
    references, count = tiles.references, 0
    for i in range(before.size):
        row, column = places[i, 0], places[i, 1]
        old, tile, new = before[i], other[row, column], table[row, column]
        if tile != old:
            if tiles.ends[tile] == EMPTY and tiles.scans[tile] < number:
                if count < left.shape[0]:
                    left[count] = places[i]
                count += 1
        elif new != old:
            other[row, column] = new
            references[new] += 1
            if old != EMPTY:
                references[old] -= 1
                if references[old] == 0:
                    tiles.free_tiles[tiles.free[TILES]] = old
                    tiles.free[TILES] += 1
    return count


@njit(cache=True, nogil=True)
def write_free(
    number: int,
    leader: int,
    tables: np.ndarray,
    scan: BeamEnds,
    before: np.ndarray,
    corner: np.ndarray,
    stamp: int,
    deferred: DeferredScans,
    tiles: Tiles,
) -> None:
    """Enter a scan that waits into the free tiles of a particle, and of others with the same pose.

    These get the same tiles, where they had the same ones before. All scans before this one must be entered
    already; particles of which this is not true are left out. ``before`` (tiles of the board,) is scratch.
    There must be room for the scan's tiles, and LEFT_MAX for each particle.
    """
    slot = number % deferred.counts.size
    table, poses, settled = tables[leader], deferred.poses[slot], deferred.settled
    place(poses[leader], scan.points, scan.placed)
    box = tiles_around(scan.placed[0], scan.placed[1:])
    # the window may have grown since
    right, up = deferred.corners[slot, 0] - corner[0], deferred.corners[slot, 1] - corner[1]
    there = box[0] + right, box[1] + up, box[2] + right, box[3] + up
    width = box[2] - box[0] + 1
    area, at = width * (box[3] - box[1] + 1), 0
    for row in range(there[1], there[3] + 1):
        for column in range(there[0], there[2] + 1):
            tile = table[row, column]
            before[at] = tile
            scan.are_wanted[at] = tiles.ends[tile] == EMPTY and tiles.scans[tile] < number
            at += 1
    scan.are_passed[:area] = False
    enter_beams(table, stamp, number, box, there, deferred.parts[slot, leader], scan, tiles)
    places, count = np.empty((area, 2), np.int64), 0
    for at in range(area):
        row, column = there[1] + at // width, there[0] + at % width
        is_written = scan.are_wanted[at] and tiles.scans[table[row, column]] == number
        if is_written or scan.are_passed[at]:
            before[count] = before[at]
            places[count, 0], places[count, 1] = row, column
            count += 1
    scan.are_wanted[:area] = False
    settled[leader] = number
    left = np.empty((LEFT_MAX, 2), np.int64)
    for p in range(tables.shape[0]):
        if settled[p] != number - 1 or not (poses[p] == poses[leader]).all():
            continue
        more = _share(table, tables[p], places[:count], before[:count], number, left, tiles)
        if more > LEFT_MAX:
            continue
        for row, column in left[:more]:
            settle_place(p, tables[p], row, column, corner, number + 1, stamp, deferred, tiles)
        settled[p] = number
