"""Tiles of voxels: what a kernel reads and writes.

A tile is a cube of SIDE voxels a side. A voxel holds its log-odds as OctoMap's node does, in float32, and NaN
while no beam has met it. A table of places (z, y, x) holds each place's tile.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

SIDE_BITS = 4
SIDE = 1 << SIDE_BITS
"""Voxels along a tile's side."""
VOXELS = SIDE**3
"""Of a tile; in the order z, y, x."""
ROWS = SIDE**2
"""Of a tile: SIDE voxels along x."""
UNSEEN = 0
"""Index of the tile in which no voxel is known. Nothing writes to it."""
CLOSED = -1
"""In a table: a place that must not be written."""
KEY_MAX = 1 << 15
"""Voxels from the map's origin to the end of OctoMap's octree, whose keys have 16 bits."""


class Tiles(NamedTuple):
    """Arrays of a pool of tiles; the first axis is the tile."""

    log_odds: np.ndarray
    """(tiles * VOXELS,) float32."""
    sure: np.ndarray
    """(tiles * ROWS,) uint16: a bit for each voxel of a row that is known to have the least log-odds. A miss
    does not change it."""
    written: np.ndarray
    """(tiles,) int64: stamp of the last change of a value."""
    turned: np.ndarray
    """(tiles,) int64: stamp of the last change between unknown, free and occupied."""
    unused: np.ndarray
    """(tiles,) int32: stack of unused tiles."""
    left: np.ndarray
    """(1,) int64: number of tiles on the stack."""


class Model(NamedTuple):
    """The sensor model in log-odds, rounded to float32 as OctoMap rounds them."""

    hit: np.float32
    miss: np.float32
    low: np.float32
    high: np.float32
