"""A map of voxels in tiles, equal to OctoMap's octree of the same clouds, voxel for voxel."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from gridslam.volume.board import Board, Rays, rays_of
from gridslam.volume.kernels.insertion import enter_board
from gridslam.volume.kernels.tiles import CLOSED, UNSEEN
from gridslam.volume.parameters import VolumeParameters
from gridslam.volume.tile_pool import TilePool
from gridslam.volume.tile_table import Box, TileTable, dense_of


class VoxelMap(TileTable):
    """Log-odds of voxels. It grows in any direction, as far as OctoMap's keys reach."""

    def __init__(self, parameters: VolumeParameters):
        super().__init__(parameters.resolution_m)
        self.parameters = parameters
        self.pool = TilePool()
        self.stamp = 0
        """How many times the map was written."""
        self._model = parameters.model

    def rays(self, origin: ArrayLike, points: ArrayLike) -> Rays:
        """Return the rays from an origin (3,) to points (n, 3) in the map's frame, m, rounded to float32.

        Raises:
            MapError: the origin is outside all that an octree can hold.
        """
        as_points = np.ascontiguousarray(points, np.float32).reshape(-1, 3)
        settings = self.parameters
        return rays_of(np.asarray(origin, np.float32), as_points, settings.resolution_m, settings.max_range_m)

    def insert(self, rays: Rays, board: Board) -> np.ndarray:
        """Enter a cloud: a miss for each voxel that rays cross, a hit for each in which one ends; a hit wins.

        Returns (d, h, w) bool from the tile ``rays.low`` on: the tiles in which a voxel is meant.

        Raises:
            MapError: the map or the cloud would be too large.
        """
        self.cover(rays.low, rays.low + rays.shape)
        board.mark(rays, self.parameters.resolution_m)
        self.stamp += 1
        are_touched = np.zeros(int(np.prod(rays.shape)), np.uint8)
        while not enter_board(
            board.misses,
            board.hits,
            rays.low,
            rays.shape,
            self.table,
            self.corner,
            self.stamp,
            self._model,
            self.pool.tiles,
            are_touched,
        ):
            self.pool.grow()
        return are_touched.reshape(rays.shape[::-1]).view(bool)

    def close_outside(self, are_open: np.ndarray) -> None:
        """Let insertions write only to open places (d, h, w) of the table, and to none outside of it."""
        self._outside = CLOSED
        self.table[~are_open] = CLOSED

    def take_tiles(self, other: VoxelMap, are_meant: np.ndarray) -> None:
        """Copy another map's tiles into the places (d, h, w) of this empty map's table that are meant."""
        places = np.argwhere(are_meant)
        theirs = places + (self.corner - other.corner)[::-1]
        inside = ((theirs >= 0) & (theirs < other.table.shape)).all(axis=1)
        places, theirs = places[inside], theirs[inside]
        tiles = other.table[tuple(theirs.T)]
        places, tiles = places[tiles > UNSEEN], tiles[tiles > UNSEEN]
        self.stamp += 1
        taken = self.pool.take(len(tiles), self.stamp)
        self.pool.copy(taken, other.pool, tiles)
        self.table[tuple(places.T)] = taken

    def copy(self) -> VoxelMap:
        """Return a map of the same voxels."""
        copied = VoxelMap(self.parameters)
        if self.table.size:
            copied.cover(self.corner, self.corner + np.array(self.table.shape[::-1]))
            copied.take_tiles(self, np.ones(copied.table.shape, bool))
        return copied

    def values(self, box: Box) -> np.ndarray:
        """Return the log-odds (d, h, w) of a box of voxels, z, y, x; NaN where a voxel is not known."""
        return dense_of(self, self.pool.cubes, box)
