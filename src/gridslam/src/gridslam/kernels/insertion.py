"""Enters a scan into a particle's tiles.

A beam is a line from the lidar's cell to the cell of its end. Along its major axis it meets each column of
cells once, at the row where it crosses the column's middle. Beams are first counted on a board, which is
then added to the tiles. So each tile is looked up once for all beams that cross it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gridslam.kernels.board import WORDS, carries, count_beam, counted, parts_of, tiles_around
from gridslam.kernels.tiles import (
    COUNT_MAX,
    EMPTY,
    FULLNESS,
    MASK,
    PARTS,
    SIDE,
    SIDE_BITS,
    Tiles,
    own_ends,
    own_tiles,
)
from kernel_cache.compiler import njit


class BeamEnds(NamedTuple):
    """A scan's beams, in cells, and scratch arrays."""

    points: np.ndarray
    """(n + 1, 2) the lidar and the beams' ends, in the base frame."""
    are_hits: np.ndarray
    """(n,) which beams end at something."""
    placed: np.ndarray
    """(n + 1, 2) scratch."""
    board: np.ndarray
    """(cells,) uint8, scratch: 0 before, and 0 again afterwards."""
    are_crossed: np.ndarray
    """(tiles of the board,) bool, scratch, likewise."""
    are_wanted: np.ndarray
    """(tiles of the board,) bool, scratch, likewise: which tiles the beams are entered into."""
    are_passed: np.ndarray
    """(tiles of the board,) bool, scratch: takes which tiles beams cross that they are not entered into."""


@njit(cache=True, nogil=True)
def place(pose: np.ndarray, points: np.ndarray, placed: np.ndarray) -> None:
    """Transform points (n, 2) from the frame of a pose (3,) into ``placed``."""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    for i in range(points.shape[0]):
        placed[i, 0] = pose[0] + cos * points[i, 0] - sin * points[i, 1]
        placed[i, 1] = pose[1] + sin * points[i, 0] + cos * points[i, 1]


@njit(cache=True, nogil=True, inline="always")
def _count(
    tile: int, cell: int, more_visits: int | np.int64, more_hits: int, entry: int, tiles: Tiles
) -> np.int64:
    """Add to a cell's counts, and update its bit.

    Halve the counts if they would overflow. Return its hits.
    """
    met = np.int64(tiles.visits[tile, cell]) + more_visits
    ended = np.int64(tiles.hits[entry, cell]) + more_hits
    while met > COUNT_MAX:
        met, ended = met >> 1, (ended + 1) >> 1
    tiles.visits[tile, cell] = met
    if entry != EMPTY:
        tiles.hits[entry, cell] = ended
    row, bit = cell >> SIDE_BITS, np.int64(1) << (cell & MASK)
    others = np.int64(tiles.occupied[tile, row]) & ~bit
    tiles.occupied[tile, row] = others | bit if ended > FULLNESS * met else others
    return ended


@njit(cache=True, nogil=True)
def _clear_bits(tile: int, words: np.ndarray, entry: int, tiles: Tiles) -> None:
    """Clear the bits of counted cells in which too few beams have ended."""
    visits, occupied, hits = tiles.visits, tiles.occupied, tiles.hits
    for row in range(SIDE):
        if occupied[tile, row] == 0:
            continue
        bits = np.int64(occupied[tile, row]) & np.int64(counted(words, row))
        cell = row * SIDE
        while bits:
            if bits & 1 and hits[entry, cell] <= FULLNESS * visits[tile, cell]:
                occupied[tile, row] &= ~(np.uint32(1) << np.uint32(cell & MASK))
            bits >>= 1
            cell += 1


@njit(cache=True, nogil=True)
def _add_one_by_one(tile: int, part: np.ndarray, tiles: Tiles) -> None:
    """Add a tile's part of the board cell by cell, because some count would overflow."""
    for cell in range(part.size):
        more = np.int64(part[cell])
        if more > 0:
            _count(tile, cell, more, 0, tiles.ends[tile], tiles)


@njit(cache=True, nogil=True, inline="always")
def _moved(mean: float, value: float, number: int | np.int64) -> np.uint16:
    """Return the mean of ``number`` values, in parts of a cell, after adding the last one."""
    old = float(mean)
    return np.uint16(min(old + (value * PARTS - old) / number + 0.5, PARTS - 1.0))


@njit(cache=True, nogil=True, inline="always")
def _hit(tile: int, end: np.ndarray, entry: int, tiles: Tiles) -> None:
    """Count a beam's end in its cell, and move the mean of the cell's hits."""
    x, y = int(end[0]), int(end[1])
    cell = (y & MASK) * SIDE + (x & MASK)
    number = _count(tile, cell, 1, 1, entry, tiles)
    means = tiles.means
    means[entry, cell, 0] = _moved(means[entry, cell, 0], end[0] - x, number)
    means[entry, cell, 1] = _moved(means[entry, cell, 1], end[1] - y, number)


@njit(cache=True, nogil=True, inline="always")
def _add_words(words: np.ndarray, first: int, visits: np.ndarray, tile: int) -> np.uint64:
    """Add a tile's words, from ``first`` on, to its visits. Return nonzero if a cell has overflown."""
    carried = np.uint64(0)
    # Both arrays have one axis, and indices no sign. So the compiler adds many words at once.
    source, target = np.uint64(first), np.uint64(tile * WORDS)
    for word in range(WORDS):
        more, old = words[source + np.uint64(word)], visits[target + np.uint64(word)]
        total = old + more
        visits[target + np.uint64(word)] = total
        carried |= carries(old, more, total)
    return carried


@njit(cache=True, nogil=True, inline="always")
def add_part(words: np.ndarray, first: int, visits: np.ndarray, tile: int, tiles: Tiles) -> None:
    """Add a tile's words of the board, from ``first`` on, to its counts, and clear them."""
    ends = tiles.ends
    if _add_words(words, first, visits, tile):
        for word in range(WORDS):
            visits[tile * WORDS + word] -= words[first + word]
        if ends[tile] != EMPTY:  # the next count halves the hits
            own_ends(tile, tiles)
        _add_one_by_one(tile, words[first : first + WORDS].view(np.uint8), tiles)
    if ends[tile] != EMPTY:
        _clear_bits(tile, words[first : first + WORDS], ends[tile], tiles)
    for word in range(WORDS):
        words[np.uint64(first + word)] = 0


@njit(cache=True, nogil=True)
def _add_board(table: np.ndarray, box: tuple[int, int, int, int], scan: BeamEnds, tiles: Tiles) -> None:
    """Add the board's counts to the table's own tiles in a box, and clear the board."""
    words, are_crossed = scan.board.view(np.uint64), scan.are_crossed
    visits = tiles.visits.view(np.uint64).ravel()
    width = box[2] - box[0] + 1
    for place in range(width * (box[3] - box[1] + 1)):
        if are_crossed[place]:
            are_crossed[place] = False
            tile = table[box[1] + place // width, box[0] + place % width]
            add_part(words, place * WORDS, visits, tile, tiles)


@njit(cache=True, nogil=True)
def _clear_unwanted(box: tuple[int, int, int, int], scan: BeamEnds) -> None:
    """Clear the board where it is not wanted."""
    words, are_crossed, are_wanted = scan.board.view(np.uint64), scan.are_crossed, scan.are_wanted
    for place in range((box[2] - box[0] + 1) * (box[3] - box[1] + 1)):
        if are_crossed[place] and not are_wanted[place]:
            are_crossed[place], scan.are_passed[place] = False, True
            for word in range(place * WORDS, (place + 1) * WORDS):
                words[np.uint64(word)] = 0


@njit(cache=True, nogil=True)
def add_at_home(table: np.ndarray, x: int, y: int, count: int | np.int64, tiles: Tiles) -> None:
    """Add this many beams to the lidar's own cell of a table, where they begin."""
    tile = table[y >> SIDE_BITS, x >> SIDE_BITS]
    if tiles.ends[tile] != EMPTY:  # hits may be halved
        own_ends(tile, tiles)
    _count(tile, (y & MASK) * SIDE + (x & MASK), count, 0, tiles.ends[tile], tiles)


@njit(cache=True, nogil=True)
def _add_hits(table: np.ndarray, points: np.ndarray, are_hits: np.ndarray, tiles: Tiles) -> None:
    """Count the beams' ends (n, 2) that are hits."""
    for i in range(points.shape[0]):
        if are_hits[i]:
            tile = table[int(points[i, 1]) >> SIDE_BITS, int(points[i, 0]) >> SIDE_BITS]
            entry = tiles.ends[tile]
            if entry == EMPTY or tiles.end_references[entry] > 1:
                entry = own_ends(tile, tiles)
            _hit(tile, points[i], entry, tiles)


@njit(cache=True, nogil=True)
def _mark_points(
    points: np.ndarray, are_meant: np.ndarray, box: tuple[int, int, int, int], are_crossed: np.ndarray
) -> None:
    """Mark the places in a box of the points (n, 2) that are meant (n,)."""
    for i in range(points.shape[0]):
        if are_meant[i]:
            row, column = int(points[i, 1]) >> SIDE_BITS, int(points[i, 0]) >> SIDE_BITS
            are_crossed[(row - box[1]) * (box[2] - box[0] + 1) + column - box[0]] = True


@njit(cache=True, nogil=True)
def enter_beams(
    table: np.ndarray,
    stamp: int,
    number: int | np.int64,
    box: tuple[int, int, int, int],
    there: tuple[int, int, int, int],
    parts: int,
    scan: BeamEnds,
    tiles: Tiles,
) -> None:
    """Enter placed beams, without their ends, into the wanted tiles of a map.

    ``box`` are the beams' tiles, ``there`` the same ones in the table, which may begin elsewhere. ``number``
    is the scan's, ``parts`` that of `parts_of`.
    """
    lidar, points = scan.placed[0], scan.placed[1:]
    left, low, right, _ = box
    width = right - left + 1
    at_home = np.int64(0)
    for part in range(parts):
        in_part = 0
        for i in range(part, points.shape[0], parts):
            in_part += count_beam(
                lidar,
                points[i],
                scan.board,
                scan.are_wanted,
                scan.are_crossed,
                scan.are_passed,
                width,
                left * SIDE,
                low * SIDE,
            )
        at_home += in_part
        _mark_points(scan.placed[:1], np.full(1, in_part > 0), box, scan.are_crossed)
        _clear_unwanted(box, scan)
        own_tiles(table, there, scan.are_crossed, stamp, number, tiles)
        _add_board(table, there, scan, tiles)
    x, y = int(lidar[0]), int(lidar[1])
    if at_home and scan.are_wanted[((y >> SIDE_BITS) - low) * width + (x >> SIDE_BITS) - left]:
        add_at_home(table, x + (there[0] - left) * SIDE, y + (there[1] - low) * SIDE, at_home, tiles)


@njit(cache=True, nogil=True)
def insert_beams(
    table: np.ndarray,
    stamp: int,
    number: int | np.int64,
    box: tuple[int, int, int, int],
    parts: int,
    scan: BeamEnds,
    tiles: Tiles,
) -> None:
    """Enter placed beams into one particle's map: into the wanted tiles, and into those where they end.

    Afterwards no tile is wanted.
    """
    points, area = scan.placed[1:], (box[2] - box[0] + 1) * (box[3] - box[1] + 1)
    _mark_points(points, scan.are_hits, box, scan.are_wanted)
    _mark_points(points, scan.are_hits, box, scan.are_crossed)
    enter_beams(table, stamp, number, box, box, parts, scan, tiles)
    scan.are_wanted[:area] = False
    _add_hits(table, points, scan.are_hits, tiles)


@njit(cache=True, nogil=True)
def _insert(table: np.ndarray, pose: np.ndarray, scan: BeamEnds, stamp: int, tiles: Tiles) -> bool:
    """Enter a scan into one map. Return False, and do nothing, if there may be too few free tiles or ends."""
    place(pose, scan.points, scan.placed)
    box = tiles_around(scan.placed[0], scan.placed[1:])
    area = (box[2] - box[0] + 1) * (box[3] - box[1] + 1)
    if tiles.free.min() < area:
        return False
    scan.are_wanted[:area] = True
    # np.int64: a literal would have all this compiled once more
    insert_beams(table, stamp, np.int64(0), box, parts_of(scan.placed[0], scan.placed[1:]), scan, tiles)
    return True


@njit(cache=True, nogil=True)
def insert_scan(
    particle: int, tables: np.ndarray, poses: np.ndarray, scan: BeamEnds, stamp: int, tiles: Tiles
) -> int:
    """Enter a scan into the maps of all particles from ``particle`` on.

    A beam visits the cells that it crosses, and also hits the cell of its end. ``tables`` (particles, h, w)
    and ``poses`` (particles, 3) are the particles' maps and poses. ``stamp`` + p marks the tiles written by
    particle p. Returns the number of particles. If there may be too few free tiles or ends for a particle,
    it stops before that particle and returns its index.
    """
    for p in range(particle, tables.shape[0]):
        if not _insert(tables[p], poses[p], scan, stamp + p, tiles):
            return p
    return tables.shape[0]


@njit(cache=True, nogil=True)
def insert_path(
    first: int,
    table: np.ndarray,
    poses: np.ndarray,
    starts: np.ndarray,
    scans: BeamEnds,
    stamp: int,
    tiles: Tiles,
) -> int:
    """Enter scans from ``first`` on, taken at poses (k, 3), into one map, as `insert_scan` does.

    ``scans`` holds the points of all of them. Scan i has those from starts[i] to
    starts[i + 1], (k + 1,), and the same hits (n,). Returns the number of scans. If there may be too few
    free tiles or ends for a scan, it stops before that scan and returns its index.
    """
    for i in range(first, poses.shape[0]):
        begin, end = starts[i], starts[i + 1]
        scan = BeamEnds(
            scans.points[begin:end],
            scans.are_hits[begin + 1 : end],
            scans.placed[begin:end],
            scans.board,
            scans.are_crossed,
            scans.are_wanted,
            scans.are_passed,
        )
        if not _insert(table, poses[i], scan, stamp + i, tiles):
            return i
    return poses.shape[0]
