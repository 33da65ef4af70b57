"""The border of what is known: unknown voxels beside free ones (Yamauchi, 1997), in cells."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from inspection_tools.exploration.kernels.borders import mark_border


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
    is_border = np.zeros(kinds.shape, bool)
    mark_border(kinds, is_border)
    return np.argwhere(is_border)


def in_cells(voxels: np.ndarray, side: int, corner: np.ndarray) -> Frontiers:
    """Return the cells of so many voxels along a side that hold frontier voxels (n, 3).

    A cell's place is its voxel nearest to the mean of its voxels. corner: (3,) z, y, x of the map's
    first voxel: so cells stay where they are when the map grows.
    """
    if not len(voxels):
        return Frontiers(np.zeros((0, 3), np.int64), np.zeros(0, np.int64))
    cubes = (voxels + corner) // side
    cubes -= cubes.min(axis=0)
    size = cubes.max(axis=0) + 1
    flat = (cubes[:, 0] * size[1] + cubes[:, 1]) * size[2] + cubes[:, 2]
    _, cell, counts = np.unique(flat, return_inverse=True, return_counts=True)
    means = np.stack([np.bincount(cell, voxels[:, axis]) for axis in range(3)], axis=1) / counts[:, None]
    off = np.square(voxels - means[cell]).sum(axis=1)
    order = np.lexsort((off, cell))
    first = order[np.concatenate(([0], np.cumsum(counts)[:-1]))]
    return Frontiers(voxels[first], counts)
