"""Tiles of cells, and how a particle gets a tile of its own before it writes into it.

A tile is SIDE x SIDE cells. Each cell counts how many beams met it (visits). Where beams ended in a tile, it
has an entry of ends, too: each cell's hits, and their mean. Tiles may share ends, as tables may share tiles.
So beams that only cross a tile copy no ends.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

SIDE_BITS = 5
SIDE = 1 << SIDE_BITS
"""Cells along a tile's side."""
MASK = SIDE - 1
COUNT_MAX = 255
"""Greatest count of a cell; visits and hits are halved before they exceed it."""
PARTS = 65536
"""Parts of a cell in which the means of its hits are kept."""
FULLNESS = 0.1
"""A cell that more than this share of its beams hit is occupied to the scan matcher."""
EMPTY = 0
"""Index of the tile in which nothing was ever seen, and of the ends that no beam has."""
TILES, ENDS = 0, 1


class Tiles(NamedTuple):
    """Arrays of a pool of tiles; the first axis is the tile, the entry of ends, or the place in a stack."""

    references: np.ndarray
    """(tiles,) in how many tables a tile is."""
    stamps: np.ndarray
    """(tiles,) when a tile was last written."""
    visits: np.ndarray
    """(tiles, SIDE * SIDE) uint8, row by row."""
    occupied: np.ndarray
    """(tiles, SIDE) one bit for each cell of a row that the scan matcher takes for occupied."""
    ends: np.ndarray
    """(tiles,) which entry of ends a tile has."""
    end_references: np.ndarray
    """(ends,) how many tiles have an entry."""
    hits: np.ndarray
    """(ends, SIDE * SIDE) uint8: how many beams ended in a cell."""
    means: np.ndarray
    """(ends, SIDE * SIDE, 2) mean x, y of the hits from the cell's corner, in 1 / PARTS of a cell."""
    free_tiles: np.ndarray
    """Stack of unused tiles."""
    free_ends: np.ndarray
    """Stack of unused entries of ends."""
    free: np.ndarray
    """(2,) how many there are on either stack: TILES, ENDS."""


@njit(cache=True, nogil=True, inline="always")
def own_tile(table: np.ndarray, row: int, column: int, stamp: int, tiles: Tiles) -> int:
    """Return a tile that a table has for its own at a place, a copy if others have it too; stamp it."""
    tile = table[row, column]
    if tile == EMPTY or tiles.references[tile] > 1:
        tiles.free[TILES] -= 1
        own = tiles.free_tiles[tiles.free[TILES]]
        tiles.visits[own] = tiles.visits[tile]
        tiles.occupied[own] = tiles.occupied[tile]
        tiles.ends[own] = tiles.ends[tile]
        tiles.references[own] = 1
        if tiles.ends[own] != EMPTY:
            tiles.end_references[tiles.ends[own]] += 1
        if tile != EMPTY:
            tiles.references[tile] -= 1
        table[row, column] = own
        tile = own
    tiles.stamps[tile] = stamp
    return tile


@njit(cache=True, nogil=True, inline="always")
def own_ends(tile: int, tiles: Tiles) -> int:
    """Return the entry of ends that a tile has for its own, copied if others have it too."""
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
