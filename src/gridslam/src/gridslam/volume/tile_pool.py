"""The tiles of a voxel map: which are in use, and room for more."""

from __future__ import annotations

import mmap

import numpy as np

from gridslam.maps.mapped_arrays import mapped_zeros, size_bytes
from gridslam.volume.kernels.tiles import ROWS, VOXELS, Tiles

FIRST = 1024
"""Tiles of the first pool. Only tiles that are written take memory."""


class TilePool:
    """Tiles by index; the first is the one in which no voxel is known."""

    def __init__(self) -> None:
        self.tiles = Tiles(
            mapped_zeros((FIRST * VOXELS,), np.float32),
            np.zeros(FIRST * ROWS, np.uint16),
            np.zeros(FIRST, np.int64),
            np.zeros(FIRST, np.int64),
            np.arange(FIRST - 1, 0, -1, dtype=np.int32),
            np.array([FIRST - 1]),
        )
        """The kernels' arrays."""
        self.tiles.log_odds[:VOXELS] = np.nan

    @property
    def used(self) -> int:
        """Number of tiles in use."""
        return self.tiles.written.size - 1 - int(self.tiles.left[0])

    @property
    def cubes(self) -> np.ndarray:
        """(tiles, VOXELS) log-odds, a view. No other variable may hold it when the pool grows."""
        return self.tiles.log_odds.reshape(-1, VOXELS)

    @property
    def sure_rows(self) -> np.ndarray:
        """(tiles, ROWS) uint16, a view; see `Tiles`."""
        return self.tiles.sure.reshape(-1, ROWS)

    def grow(self, least: int = 1) -> None:
        """Make room for half as many tiles again, at least for this many more."""
        old = self.tiles.written.size
        new = old + max(old // 2, least)
        memory = self.tiles.log_odds.base
        sure, written, turned, unused, left = self.tiles[1:]
        assert isinstance(memory, mmap.mmap)  # `mapped_zeros` gave it
        self.tiles = self.tiles._replace(log_odds=np.empty(0, np.float32))  # memory in use cannot grow
        memory.resize(size_bytes((new * VOXELS,), np.float32))
        self.tiles = Tiles(
            np.ndarray((new * VOXELS,), np.float32, memory),
            np.concatenate((sure, np.zeros((new - old) * ROWS, np.uint16))),
            np.concatenate((written, np.zeros(new - old, np.int64))),
            np.concatenate((turned, np.zeros(new - old, np.int64))),
            np.concatenate((np.arange(new - 1, old - 1, -1, dtype=np.int32), unused[: left[0]])),
            left + (new - old),
        )

    def reserve(self, count: int) -> None:
        """Make room for this many more tiles."""
        if self.tiles.left[0] < count:
            self.grow(count)

    def take(self, count: int, stamp: int) -> np.ndarray:
        """Return this many tiles, in which no voxel is known."""
        self.reserve(count)
        self.tiles.left[0] -= count
        left = int(self.tiles.left[0])
        taken = self.tiles.unused[left : left + count].copy()
        self.cubes[taken] = np.nan
        self.sure_rows[taken] = 0
        self.tiles.written[taken] = self.tiles.turned[taken] = stamp
        return taken

    def copy(self, tiles: np.ndarray, other: TilePool, theirs: np.ndarray) -> None:
        """Copy the voxels of another pool's tiles (n,) into these (n,). The sensor models agree."""
        self.cubes[tiles] = other.cubes[theirs]
        self.sure_rows[tiles] = other.sure_rows[theirs]

    def give_back(self, tiles: np.ndarray) -> None:
        """Let these tiles be used again."""
        left = int(self.tiles.left[0])
        self.tiles.unused[left : left + tiles.size] = tiles
        self.tiles.left[0] += tiles.size
