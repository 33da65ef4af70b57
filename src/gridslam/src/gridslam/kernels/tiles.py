"""Tiles of cells, and copy on write: a particle gets its own tile before it writes into it.

A tile is SIDE x SIDE cells. Each cell counts the beams that met it (visits). If beams ended in a tile, it
also has an entry of ends: each cell's hits, and their mean. Tiles may share ends, as tables may share tiles.
So beams that only cross a tile copy no ends.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kernel_cache.compiler import njit

SIDE_BITS = 5
SIDE = 1 << SIDE_BITS
"""Cells along a tile's side."""
MASK = SIDE - 1
COUNT_MAX = 255
"""Greatest count of a cell; visits and hits are halved before they exceed it."""
PARTS = 65536
"""Resolution of the means: parts of a cell."""
FULLNESS = 0.1
"""If more than this share of a cell's beams ended in it, scan matching takes it as occupied."""
EMPTY = 0
"""Index of the empty tile and of the empty ends."""
TILES, ENDS = 0, 1


class Tiles(NamedTuple):
    """Arrays of a pool of tiles; the first axis is the tile, the entry of ends, or the place in a stack."""

    references: np.ndarray
    """(tiles,) number of tables that hold a tile."""
    stamps: np.ndarray
    """(tiles,) when a tile was last written."""
    scans: np.ndarray
    """(tiles,) number of the last scan that is entered, in tiles without ends; see `waiting`."""
    visits: np.ndarray
    """(tiles, SIDE * SIDE) uint8, row by row."""
    occupied: np.ndarray
    """(tiles, SIDE) a bit for each cell of a row: occupied for the scan matcher."""
    ends: np.ndarray
    """(tiles,) index of a tile's entry of ends."""
    end_references: np.ndarray
    """(ends,) number of tiles that have an entry."""
    hits: np.ndarray
    """(ends, SIDE * SIDE) uint8: number of beams that ended in a cell."""
    means: np.ndarray
    """(ends, SIDE * SIDE, 2) mean x, y of the hits from the cell's corner, in 1 / PARTS of a cell."""
    free_tiles: np.ndarray
    """Stack of unused tiles."""
    free_ends: np.ndarray
    """Stack of unused entries of ends."""
    free: np.ndarray
    """(2,) number of entries on each stack: TILES, ENDS."""


@njit(cache=True, nogil=True)
def own_tiles(
    table: np.ndarray,
    box: tuple[int, int, int, int],
    are_wanted: np.ndarray,
    stamp: int,
    number: int | np.int64,
    tiles: Tiles,
) -> None:
    """Give a table its own tiles at the wanted places of a box, and stamp them. Copy what others share.

    ``box`` is the first column and row and the last ones; ``are_wanted`` (places,) bool goes row by row.
    ``number`` is that of the scan which will be entered.
    """
    # No array is handed on in the loop: each would cost more than the rest.
    references, stamps, visits, occupied = tiles.references, tiles.stamps, tiles.visits, tiles.occupied
    scans = tiles.scans
    ends, end_references, free_tiles, free = tiles.ends, tiles.end_references, tiles.free_tiles, tiles.free
    width = box[2] - box[0] + 1
    for place in range(width * (box[3] - box[1] + 1)):
        if not are_wanted[place]:
            continue
        row, column = box[1] + place // width, box[0] + place % width
        tile = table[row, column]
        if references[tile] != 1:
            free[TILES] -= 1
            own = free_tiles[free[TILES]]
            visits[own] = visits[tile]
            occupied[own] = occupied[tile]
            ends[own] = ends[tile]
            references[own] = 1
            if ends[own] != EMPTY:
                end_references[ends[own]] += 1
            if tile != EMPTY:
                references[tile] -= 1
            table[row, column] = own
            tile = own
        stamps[tile], scans[tile] = stamp, number


@njit(cache=True, nogil=True, inline="always")
def own_ends(tile: int, tiles: Tiles) -> int:
    """Return a tile's own entry of ends. If other tiles share the entry, copy it first."""
    entry = tiles.ends[tile]
    if entry == EMPTY or tiles.end_references[entry] > 1:
        tiles.free[ENDS] -= 1
        own = tiles.free_ends[tiles.free[ENDS]]
        tiles.hits[own] = tiles.hits[entry]
        tiles.means[own] = tiles.means[entry]
        tiles.end_references[own] = 1
        if entry != EMPTY:
            tiles.end_references[entry] -= 1
        tiles.ends[tile] = own
        entry = own
    return entry
