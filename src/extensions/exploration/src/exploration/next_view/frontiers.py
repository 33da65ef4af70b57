"""The border of what is known: unknown voxels beside free ones (Yamauchi, 1997), in cells."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from exploration.next_view.kernels.borders import border_of, cells_of
from exploration.planning.voxel_grid import VoxelGrid


class Frontiers(NamedTuple):
    """Cells with frontier voxels.

    places: (n, 3), z, y, x, of a voxel in each. counts: (n,) voxels in each.
    """

    places: np.ndarray
    counts: np.ndarray

    def chosen(self, which: np.ndarray) -> Frontiers:
        """Return those that a mask or indices choose."""
        return Frontiers(self.places[which], self.counts[which])


def frontier_voxels(kinds: np.ndarray) -> np.ndarray:
    """Return (n, 3), z, y, x: the unknown voxels with a free one beside a face."""
    border: np.ndarray = border_of(kinds, np.zeros(3, np.int64), np.array(kinds.shape))
    return border


class KnownBorder:
    """Keeps the border of a map that grows, and looks anew only at the tiles that have changed."""

    def __init__(self) -> None:
        self._grid: VoxelGrid | None = None
        self._first = np.zeros(3, np.int64)
        self._versions = np.zeros((0, 0, 0), np.int64)
        self._tiles: dict[tuple[int, int, int], np.ndarray] = {}
        """By tile, z, y, x from the frame's origin: its border (n, 3), voxels counted likewise."""

    def of(self, grid: VoxelGrid, kinds: np.ndarray) -> np.ndarray:
        """Return `frontier_voxels` of a map's kinds with one layer around."""
        if self._grid is not grid:
            self._grid, self._tiles, self._versions = grid, {}, np.zeros((0, 0, 0), np.int64)
        side, corner = grid.side, grid.corner[::-1]
        first, shape = corner // side, np.array(grid.versions.shape)
        before = np.full(shape, -1)
        at = self._first - first
        before[tuple(slice(a, a + n) for a, n in zip(at, self._versions.shape))] = self._versions
        has_changed = ndimage.binary_dilation(before != grid.versions)
        self._first, self._versions = first, grid.versions.copy()
        for tile in np.argwhere(has_changed):
            low = tile * side + 1
            # a layer around the map is unknown, and is border if the map is free up to its end
            low, high = np.where(tile == 0, 0, low), low + side + (tile + 1 == shape)
            found = border_of(kinds, low, high)
            if len(found):
                self._tiles[tuple((tile + first).tolist())] = found + (corner - 1)
            else:
                self._tiles.pop(tuple((tile + first).tolist()), None)
        if not self._tiles:
            return np.zeros((0, 3), np.int64)
        border = np.concatenate(list(self._tiles.values())) - (corner - 1)
        flat = (border[:, 0] * kinds.shape[1] + border[:, 1]) * kinds.shape[2] + border[:, 2]
        return border[np.argsort(flat, kind="stable")]  # which is fast on sorted pieces


def in_cells(voxels: np.ndarray, side: int, corner: np.ndarray) -> Frontiers:
    """Return the cells of so many voxels along a side that hold frontier voxels (n, 3).

    A cell's place is its voxel nearest to the mean of its voxels. corner: (3,) z, y, x of the map's
    first voxel: so cells stay where they are when the map grows.
    """
    if not len(voxels):
        return Frontiers(np.zeros((0, 3), np.int64), np.zeros(0, np.int64))
    nearest, counts = cells_of(voxels, side, np.asarray(corner, np.int64))
    return Frontiers(voxels[nearest], counts)
