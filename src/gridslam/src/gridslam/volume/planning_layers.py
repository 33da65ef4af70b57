"""For planners: distances to what is occupied, and frontiers; they follow a shown map tile by tile."""

from __future__ import annotations

from typing import Iterator

import numpy as np

from gridslam.errors import ParameterError
from gridslam.volume.kernels.distances import block_squares, mark_frontiers
from gridslam.volume.kernels.shown import OCCUPIED, UNKNOWN
from gridslam.volume.kernels.tiles import SIDE, VOXELS
from gridslam.volume.shown_map import ShownMap, centres_of
from gridslam.volume.tile_table import Box, TileTable, dense_of

BLOCK = 4
"""Tiles along the side of a block that is computed at once."""
REACH_MAX = 200
"""Voxels: squares of greater distances do not fit."""
STEPS = np.concatenate((np.eye(3, dtype=np.int64), -np.eye(3, dtype=np.int64)))
"""To the six neighbours that share a side."""


class DistanceField(TileTable):
    """Distance from a voxel's centre to that of the nearest occupied one, cut at a greatest distance.

    Raises:
        ParameterError: the greatest distance makes no sense for such voxels.
    """

    def __init__(self, resolution_m: float, greatest_m: float = 3.0):
        super().__init__(resolution_m)
        self.reach = round(greatest_m / resolution_m) if greatest_m > 0.0 else 0
        if not 0 < self.reach <= REACH_MAX:
            raise ParameterError(
                f"Distances must be cut at 1 to {REACH_MAX} voxels, and not at {greatest_m} m with voxels of "
                f"{resolution_m} m."
            )
        self.squares = np.full((1, VOXELS), self.reach**2, np.uint16)
        """(tiles, VOXELS) squared distances in voxels; the first tile is for what is not known."""

    def update(self, shown: ShownMap, changed: np.ndarray) -> np.ndarray:
        """Follow a shown map whose tiles (n, 3) have changed. Return the tiles (m, 3) that are new."""
        if not len(changed):
            return changed
        tiles = shown.known_tiles()
        tiles = tiles[_are_near(tiles, changed, -(-self.reach // SIDE))]
        self._require(shown, tiles)
        for block, members in _blocks(tiles):
            low = block * BLOCK * SIDE
            around = Box(low - self.reach, low + BLOCK * SIDE + self.reach)
            occupied = shown.dense(around) == OCCUPIED
            squares = block_squares(occupied, self.reach).reshape(BLOCK, SIDE, BLOCK, SIDE, BLOCK, SIDE)
            x, y, z = (members - block * BLOCK).T
            self.squares[self.indices(members)] = squares.transpose(0, 2, 4, 1, 3, 5)[z, y, x].reshape(
                -1, VOXELS
            )
        return tiles

    def _require(self, shown: ShownMap, tiles: np.ndarray) -> None:
        """Give the tiles the indices that they have in the shown map."""
        if len(tiles):
            self.cover(tiles.min(axis=0), tiles.max(axis=0) + 1)
            self.table[tuple((tiles - self.corner)[:, ::-1].T)] = shown.indices(tiles)
        if len(self.squares) < len(shown.kinds):
            more = np.full((len(shown.kinds) - len(self.squares), VOXELS), self.reach**2, np.uint16)
            self.squares = np.concatenate((self.squares, more))

    def distances_m(self, box: Box) -> np.ndarray:
        """Return the distances (d, h, w) of a box of voxels, z, y, x, float32, m."""
        squares = dense_of(self, self.squares, box)
        return np.sqrt(squares, dtype=np.float32) * np.float32(self.resolution_m)


class Frontiers:
    """Free voxels beside unknown ones."""

    def __init__(self, resolution_m: float):
        self.resolution_m = resolution_m
        self._voxels: dict[tuple[int, int, int], np.ndarray] = {}
        """(n,) places in a tile, by the tile."""

    def update(self, shown: ShownMap, changed: np.ndarray) -> None:
        """Follow a shown map whose tiles (n, 3) have changed."""
        if not len(changed):
            return
        tiles = shown.known_tiles()
        tiles = tiles[_are_near(tiles, changed, 1)]
        for block, members in _blocks(tiles):
            low = block * BLOCK * SIDE
            kinds = shown.dense(Box(low - 1, low + BLOCK * SIDE + 1))
            are_frontiers = np.empty((BLOCK * SIDE,) * 3, bool)
            mark_frontiers(kinds, are_frontiers)
            cubes = are_frontiers.reshape(BLOCK, SIDE, BLOCK, SIDE, BLOCK, SIDE).transpose(0, 2, 4, 1, 3, 5)
            for tile, (x, y, z) in zip(members.tolist(), (members - block * BLOCK).tolist()):
                self._voxels[tuple(tile)] = np.flatnonzero(cubes[z, y, x]).astype(np.uint16)

    def centres(self) -> np.ndarray:
        """Return their centres (n, 3), float32, m."""
        return centres_of(*self._places(), self.resolution_m)

    def unknown_centres(self, shown: ShownMap) -> np.ndarray:
        """Return the centres (m, 3) of the unknown voxels beside these, float32, m.

        No beam has come to them: surface that was never within any, or the room behind.
        """
        tiles, voxels = self._places()
        at = tiles * SIDE + np.stack((voxels % SIDE, voxels // SIDE % SIDE, voxels // SIDE**2), axis=1)
        beside = np.unique(np.concatenate([at + step for step in STEPS]), axis=0)
        tiles, inside = beside // SIDE, beside % SIDE
        voxels = inside[:, 0] + SIDE * (inside[:, 1] + SIDE * inside[:, 2])
        are_unknown = shown.kinds[shown.indices(tiles), voxels] == UNKNOWN
        return centres_of(tiles[are_unknown], voxels[are_unknown], self.resolution_m)

    def _places(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the tile (n, 3) of each, and its place (n,) there."""
        if not self._voxels:
            return np.zeros((0, 3), np.int64), np.zeros(0, np.int64)
        counts = [len(voxels) for voxels in self._voxels.values()]
        tiles = np.repeat(np.array(list(self._voxels), np.int64), counts, axis=0)
        return tiles, np.concatenate(list(self._voxels.values())).astype(np.int64)


def _are_near(tiles: np.ndarray, changed: np.ndarray, within: int) -> np.ndarray:
    """Return which tiles (n, 3) are within so many tiles of a changed one (k, 3), along each axis."""
    low, high = changed.min(axis=0) - within, changed.max(axis=0) + within + 1
    grid = np.zeros(high - low, bool)
    reach = np.arange(-within, within + 1)
    shifts = np.stack(np.meshgrid(reach, reach, reach, indexing="ij"), axis=-1).reshape(-1, 3)
    for shift in shifts:
        grid[tuple((changed + shift - low).T)] = True
    inside = ((tiles >= low) & (tiles < high)).all(axis=1)
    inside[inside] = grid[tuple((tiles[inside] - low).T)]
    return inside


def _blocks(tiles: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield the blocks (3,) that hold tiles (n, 3), each with its tiles (k, 3)."""
    if not len(tiles):
        return
    blocks, which = np.unique(tiles // BLOCK, axis=0, return_inverse=True)
    order = np.argsort(which.ravel(), kind="stable")
    yield from zip(blocks, np.split(tiles[order], np.cumsum(np.bincount(which.ravel()))[:-1]))
