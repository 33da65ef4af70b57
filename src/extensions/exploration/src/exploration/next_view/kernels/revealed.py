"""What beams would reveal of the unknown, if walls and floors go on and all else is empty."""

from __future__ import annotations

import numpy as np

from exploration.next_view.kernels.gates import mark_ways
from exploration.planning.voxel_grid import FREE, OCCUPIED, UNKNOWN
from kernel_cache.compiler import njit

WALL = 3
"""A wall or a floor has so many occupied voxels in a row."""
STEP = 0.7
"""Voxels between the places of a beam that are looked at."""


@njit(cache=True, nogil=True)
def mark_walls(kinds: np.ndarray, goes_on: int, is_wall: np.ndarray) -> None:
    """Set is_wall (d, h, w) at the unknown voxels that continue rows of occupied ones, so many each.

    Rows are along each axis. So walls go on upward and sideways, floors and decks sideways.
    """
    depth, height, width = kinds.shape
    for z in range(depth):
        for y in range(height):
            _go_on(kinds[z, y], goes_on, is_wall[z, y])
            _go_on(kinds[z, y, ::-1], goes_on, is_wall[z, y, ::-1])
    runs, left = np.zeros((2, width), np.int64), np.zeros((2, width), np.int64)
    for y in range(height):
        runs[:] = 0
        left[:] = 0
        for z in range(depth):
            _go_on_beside(kinds[z, y], goes_on, is_wall[z, y], runs[0], left[0])
            last = depth - 1 - z
            _go_on_beside(kinds[last, y], goes_on, is_wall[last, y], runs[1], left[1])
    for z in range(depth):
        runs[:] = 0
        left[:] = 0
        for y in range(height):
            _go_on_beside(kinds[z, y], goes_on, is_wall[z, y], runs[0], left[0])
            last = height - 1 - y
            _go_on_beside(kinds[z, last], goes_on, is_wall[z, last], runs[1], left[1])


@njit(cache=True, nogil=True)
def _go_on(kinds: np.ndarray, goes_on: int, is_wall: np.ndarray) -> None:
    """Go along one row (w,)."""
    run, left = 0, 0
    for x in range(len(kinds)):
        if kinds[x] == OCCUPIED:
            run += 1
            if run >= WALL:
                left = goes_on
        elif kinds[x] == FREE:
            run = left = 0
        elif left > 0:
            is_wall[x] = True
            left -= 1


@njit(cache=True, nogil=True)
def _go_on_beside(
    kinds: np.ndarray, goes_on: int, is_wall: np.ndarray, runs: np.ndarray, left: np.ndarray
) -> None:
    """Go on with many rows at once: one voxel (w,) of each, whose runs and what is left of them are given."""
    for x in range(len(kinds)):
        if kinds[x] == OCCUPIED:
            runs[x] += 1
            if runs[x] >= WALL:
                left[x] = goes_on
        elif kinds[x] == FREE:
            runs[x] = left[x] = 0
        elif left[x] > 0:
            is_wall[x] = True
            left[x] -= 1


@njit(cache=True, nogil=True)
def count_unknown(
    kinds: np.ndarray, is_wall: np.ndarray, side: int, offset: np.ndarray, counts: np.ndarray
) -> None:
    """Add to counts the unknown voxels of each cell but those of walls.

    side: voxels along a cell. offset: (3,) z, y, x of the first voxel in its cell.
    """
    depth, height, width = kinds.shape
    for z in range(depth):
        for y in range(height):
            for x in range(width):
                if kinds[z, y, x] == UNKNOWN and not is_wall[z, y, x]:
                    cell = (z + offset[0]) // side, (y + offset[1]) // side, (x + offset[2]) // side
                    counts[cell] += 1


@njit(cache=True, nogil=True)
def revealed(
    kinds: np.ndarray,
    is_wall: np.ndarray,
    gates: np.ndarray,
    counts: np.ndarray,
    side: int,
    offset: np.ndarray,
    places: np.ndarray,
    views: np.ndarray,
    directions: np.ndarray,
    slopes: tuple[float, float],
    reaches: tuple[float, float, float],
    stamps: np.ndarray,
) -> np.ndarray:
    """Return (v,) what each view reveals: the counts of the cells in which its beams meet unknown voxels.

    Args:
        kinds: (d, h, w) of the map.
        is_wall: (d, h, w) unknown voxels that beams do not pass.
        gates: (g, 3) of `mark_gates`. Beams from a free voxel that meet none of them are not cast.
        counts: of the cells.
        side: voxels along a cell.
        offset: as in `count_unknown`.
        places: (n, 3) z, y, x of voxels that beams begin in.
        views: (n,) the view of each place, from 0 on.
        directions: (r, a, 3) of the beams, of unit length. Along the second axis azimuths go evenly around.
        slopes: of the lowest and the highest beam, see `mark_ways`.
        reaches: nearest and farthest distance that counts, and how far a beam goes on in the unknown, voxels.
        stamps: as counts, zeros; afterwards 1 + the last view that met a cell.
    """
    gains = np.zeros(views.max() + 1, np.int64)
    rings, around = directions.shape[:2]
    is_way = np.empty(around, np.bool_)
    for n in range(len(places)):
        is_way[:] = kinds[places[n, 0], places[n, 1], places[n, 2]] != FREE
        if not is_way[0]:
            mark_ways(gates, places[n], slopes, reaches[1], is_way)
        for a in range(around):
            if is_way[a]:
                for r in range(rings):
                    gains[views[n]] += _met(
                        kinds, is_wall, counts, side, offset, places[n], directions[r, a], reaches,
                        views[n] + 1, stamps,
                    )  # fmt: skip
    return gains


@njit(cache=True, nogil=True)
def _met(
    kinds: np.ndarray,
    is_wall: np.ndarray,
    counts: np.ndarray,
    side: int,
    offset: np.ndarray,
    place: np.ndarray,
    direction: np.ndarray,
    reaches: tuple[float, float, float],
    stamp: int,
    stamps: np.ndarray,
) -> int:
    """Return the counts of the cells that a beam meets first, and stamp these."""
    depth, height, width = kinds.shape
    z, y, x = place[0] + 0.5, place[1] + 0.5, place[2] + 0.5
    way, inside, met = 0.0, 0.0, 0
    while way < reaches[1] and 0.0 <= z < depth and 0.0 <= y < height and 0.0 <= x < width:
        voxel = int(z), int(y), int(x)
        if kinds[voxel] == OCCUPIED or is_wall[voxel]:
            break
        if kinds[voxel] == UNKNOWN and way >= reaches[0]:
            inside += STEP
            if inside > reaches[2]:
                break
            cell = (
                (voxel[0] + offset[0]) // side,
                (voxel[1] + offset[1]) // side,
                (voxel[2] + offset[2]) // side,
            )
            if stamps[cell] != stamp:
                stamps[cell] = stamp
                met += counts[cell]
        z += STEP * direction[0]
        y += STEP * direction[1]
        x += STEP * direction[2]
        way += STEP
    return met
