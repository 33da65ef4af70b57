"""What a map shows: voxels that are unknown, free or occupied, with what was seen within the last seconds."""

from __future__ import annotations

import numpy as np

from gridslam.volume.corrected_map import CorrectedMap
from gridslam.volume.kernels.shown import FREE, OCCUPIED, UNKNOWN, kinds_of
from gridslam.volume.kernels.tiles import SIDE, UNSEEN, VOXELS
from gridslam.volume.octree.stream import OctreeStream, stream_of_cubes
from gridslam.volume.tile_table import Box, TileTable, dense_of
from gridslam.volume.voxel_map import VoxelMap

AT_ONCE = 256
"""Tiles whose kinds are found at once: more would need memory in proportion."""
VALUES = np.array((np.nan, -1.0, 1.0), np.float32)
"""By kind, for a binary stream."""

__all__ = ["FREE", "OCCUPIED", "UNKNOWN", "ShownMap"]


class ShownMap(TileTable):
    """Kinds of voxels, kept up to date tile by tile."""

    def __init__(self, resolution_m: float):
        super().__init__(resolution_m)
        self.kinds = np.zeros((1, VOXELS), np.uint8)
        """(tiles, VOXELS) UNKNOWN, FREE or OCCUPIED; the first tile is unknown."""
        self._used = 1
        self._source: VoxelMap | None = None
        self._stamp = 0
        self._overlaid = np.zeros((0, 3), np.int64)

    def refresh(self, corrected: CorrectedMap) -> np.ndarray:
        """Follow a map. Return the tiles (n, 3), x, y, z, in which a voxel's kind has changed."""
        voxels = corrected.voxels
        if voxels is not self._source:
            self._source, self._stamp, old = voxels, -1, self.known_tiles()
        else:
            old = np.zeros((0, 3), np.int64)
        tiles = voxels.known_tiles()
        turned = tiles[voxels.pool.tiles.turned[voxels.indices(tiles)] > self._stamp]
        overlaid = np.unique(corrected.transient.tiles(), axis=0)
        candidates = np.unique(np.concatenate((old, turned, overlaid, self._overlaid)), axis=0)
        self._stamp, self._overlaid = voxels.stamp, overlaid
        parts = [candidates[first : first + AT_ONCE] for first in range(0, len(candidates), AT_ONCE)]
        changed = [self._follow(corrected, part) for part in parts]
        return np.concatenate(changed) if changed else candidates

    def _follow(self, corrected: CorrectedMap, tiles: np.ndarray) -> np.ndarray:
        """Take over the kinds of tiles (n, 3); return those that differ."""
        kinds = np.zeros((len(tiles), VOXELS), np.uint8)
        kinds_of(corrected.voxels.indices(tiles), corrected.voxels.pool.tiles.log_odds, kinds)
        corrected.transient.lay_over(tiles, kinds)
        differ = (kinds != self.kinds[self.indices(tiles)]).any(axis=1)
        tiles, kinds = tiles[differ], kinds[differ]
        if len(tiles):
            self._require(tiles)
            self.kinds[self.indices(tiles)] = kinds
        return tiles

    def _require(self, tiles: np.ndarray) -> None:
        """Make room for tiles (n, 3)."""
        self.cover(tiles.min(axis=0), tiles.max(axis=0) + 1)
        new = tiles[self.indices(tiles) == UNSEEN]
        needed = self._used + len(new)
        if needed > len(self.kinds):
            more = max(needed, 3 * len(self.kinds) // 2) - len(self.kinds)
            self.kinds = np.concatenate((self.kinds, np.zeros((more, VOXELS), np.uint8)))
        self.table[tuple((new - self.corner)[:, ::-1].T)] = np.arange(self._used, needed)
        self._used = needed

    def dense(self, box: Box) -> np.ndarray:
        """Return the kinds (d, h, w) of a box of voxels, z, y, x."""
        return dense_of(self, self.kinds, box)

    def octree(self) -> OctreeStream:
        """Return the binary octree of what is shown."""
        return stream_of_cubes(self, True, lambda places: VALUES[self.kinds[self.table[tuple(places.T)]]])

    def centres(self, kind: int) -> np.ndarray:
        """Return the centres (n, 3) of all voxels of a kind, float32, m."""
        tiles = self.known_tiles()
        rows, voxels = np.nonzero(self.kinds[self.indices(tiles)] == kind)
        return centres_of(tiles[rows], voxels, self.resolution_m)


def centres_of(tiles: np.ndarray, voxels: np.ndarray, resolution_m: float) -> np.ndarray:
    """Return the centres (n, 3), m, of voxels (n,), by their place in tiles (n, 3)."""
    inside = np.stack((voxels % SIDE, voxels // SIDE % SIDE, voxels // SIDE**2), axis=1)
    return ((tiles * SIDE + inside + 0.5) * resolution_m).astype(np.float32)
