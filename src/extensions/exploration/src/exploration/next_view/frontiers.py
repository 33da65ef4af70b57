"""The border of what is known: unknown voxels beside free ones (Yamauchi, 1997), in cells."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from exploration.next_view.kernels.borders import border_of, cells_of
from exploration.planning.voxel_grid import VoxelGrid

OFFSET, SHIFTS = 2**20, np.array((42, 21, 0))
"""They make one number of a voxel: no map reaches a million voxels from the origin."""


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
    """Keeps a map that grows and its border, and looks anew only at the tiles that have changed."""

    def __init__(self) -> None:
        self._grid: VoxelGrid | None = None
        self._forget()

    def _forget(self) -> None:
        self._first = np.zeros(3, np.int64)
        self._versions = np.zeros((0, 0, 0), np.int64)
        self._kinds = np.zeros((0, 0, 0), np.uint8)
        self._border = np.zeros((0, 3), np.int64)
        """Voxels, z, y, x from the frame's origin, in ascending order."""
        self._tiles = np.zeros((0, 3), np.int64)
        """Tile of each, counted likewise. It holds a border voxel of the layer around the map beside it."""

    def of(self, grid: VoxelGrid) -> tuple[np.ndarray, np.ndarray]:
        """Return a map's kinds with one unknown layer around, and their `frontier_voxels`.

        The kinds belong to this object, and the next call changes them.
        """
        if self._grid is not grid:
            self._grid = grid
            self._forget()
        side, corner = grid.side, grid.corner[::-1]
        first, shape = corner // side, np.array(grid.versions.shape)
        before = np.full(shape, -1)
        at = self._first - first
        before[tuple(slice(a, a + n) for a, n in zip(at, self._versions.shape))] = self._versions
        has_news = before != grid.versions
        has_grown = self._versions.shape != grid.versions.shape or bool(at.any())
        self._take_over(grid, has_news, has_grown)
        self._first, self._versions = first, grid.versions.copy()
        if has_news.any():
            self._look_anew(ndimage.binary_dilation(has_news), first, side, corner - 1)
        return self._kinds, self._border - (corner - 1)

    def _take_over(self, grid: VoxelGrid, has_news: np.ndarray, has_grown: bool) -> None:
        """Copy the tiles that are new, or all if the map has grown."""
        if has_grown:
            self._kinds = np.pad(grid.kinds, 1)
            return
        for tile in (np.argwhere(has_news) * grid.side).tolist():
            part = tuple(slice(low, low + grid.side) for low in tile)
            self._kinds[tuple(slice(each.start + 1, each.stop + 1) for each in part)] = grid.kinds[part]

    def _look_anew(self, has_changed: np.ndarray, first: np.ndarray, side: int, corner: np.ndarray) -> None:
        """Replace the border in tiles. first: the first tile; corner: first voxel of the kinds."""
        shape, found, tiles = np.array(has_changed.shape), [], []
        for tile in np.argwhere(has_changed):
            low = tile * side + 1
            # a layer around the map is unknown, and is border if the map is free up to its end
            low, high = np.where(tile == 0, 0, low), low + side + (tile + 1 == shape)
            found.append(border_of(self._kinds, low, high) + corner)
            tiles.append(np.broadcast_to(tile + first, (len(found[-1]), 3)))
        is_kept = ~has_changed[tuple((self._tiles - first).T)]
        kept, of_kept = self._border[is_kept], self._tiles[is_kept]
        new, of_new = np.concatenate(found), np.concatenate(tiles)
        keys, new_keys = ascending(kept), ascending(new)
        order = np.argsort(new_keys, kind="stable")  # which is fast on sorted pieces
        at = np.searchsorted(keys, new_keys[order])
        self._border = np.insert(kept, at, new[order], axis=0)
        self._tiles = np.insert(of_kept, at, of_new[order], axis=0)


def ascending(voxels: np.ndarray) -> np.ndarray:
    """Return a number (n,) of each voxel (n, 3), z, y, x, that ascends as they do, z first."""
    return ((voxels + OFFSET) << SHIFTS).sum(axis=1)


def in_cells(voxels: np.ndarray, side: int, corner: np.ndarray) -> Frontiers:
    """Return the cells of so many voxels along a side that hold frontier voxels (n, 3).

    A cell's place is its voxel nearest to the mean of its voxels. corner: (3,) z, y, x of the map's
    first voxel: so cells stay where they are when the map grows.
    """
    if not len(voxels):
        return Frontiers(np.zeros((0, 3), np.int64), np.zeros(0, np.int64))
    nearest, counts = cells_of(voxels, side, np.asarray(corner, np.int64))
    return Frontiers(voxels[nearest], counts)
