"""What was seen within the last seconds: shown and used for flying, then forgotten."""

from __future__ import annotations

import math

import numpy as np

from gridslam.volume.board import Board, Rays
from gridslam.volume.kernels.shown import overlay
from gridslam.volume.kernels.tiles import UNSEEN
from gridslam.volume.parameters import VolumeParameters
from gridslam.volume.voxel_map import VoxelMap

GENERATION_S = 1.0
"""A cloud counts for at least this time, and for at most twice as long."""


class TransientLayer:
    """Two maps of voxels: of the clouds of this period, and of the one before.

    What they are sure of wins over the map: an occupied voxel, and a free one that has the least probability.
    So a door that has opened is free after five clouds, however often the map has seen it closed.
    """

    def __init__(self, parameters: VolumeParameters):
        self._parameters = parameters
        self._since_s = math.nan
        self.layers = (VoxelMap(parameters), VoxelMap(parameters))
        """The older one, and the present one."""

    def insert(self, stamp_s: float, rays: Rays, board: Board) -> None:
        """Enter a cloud."""
        if not 0.0 <= stamp_s - self._since_s < GENERATION_S:
            is_next = GENERATION_S <= stamp_s - self._since_s < 2.0 * GENERATION_S
            older = self.layers[1] if is_next else VoxelMap(self._parameters)
            self.layers = (older, VoxelMap(self._parameters))
            self._since_s = stamp_s
        self.layers[1].insert(rays, board)

    def forget(self) -> None:
        """Forget all clouds."""
        self.layers = (VoxelMap(self._parameters), VoxelMap(self._parameters))
        self._since_s = math.nan

    def tiles(self) -> np.ndarray:
        """Return the tiles (n, 3) that hold something, x, y, z from the map's origin; some of them twice."""
        return np.concatenate([layer.known_tiles() for layer in self.layers])

    def lay_over(self, tiles: np.ndarray, kinds: np.ndarray) -> None:
        """Let what is sure here replace the kinds (n, VOXELS) of tiles (n, 3), x, y, z."""
        for layer in self.layers:
            found = layer.indices(tiles)
            rows = np.flatnonzero(found != UNSEEN)
            overlay(rows, found[rows], layer.pool.tiles.log_odds, layer.parameters.model.low, kinds)
