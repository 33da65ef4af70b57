"""The border of what is known: free voxels beside unknown ones (Yamauchi, 1997), in cells."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from inspection_tools.planning import FREE, UNKNOWN


class Frontiers(NamedTuple):
    """Cells with frontier voxels.

    places: (n, 3), z, y, x, of a voxel in each. counts: (n,) voxels in each.
    """

    places: np.ndarray
    counts: np.ndarray


def frontier_voxels(kinds: np.ndarray) -> np.ndarray:
    """Return (n, 3), z, y, x: the free voxels with an unknown one beside a face. Outside all is unknown."""
    unknown = np.pad(kinds == UNKNOWN, 1, constant_values=True)
    beside = np.zeros(kinds.shape, bool)
    for axis in range(3):
        for shift in (0, 2):
            part = [slice(1, -1)] * 3
            part[axis] = slice(shift, shift + kinds.shape[axis])
            beside |= unknown[tuple(part)]
    return np.argwhere(beside & (kinds == FREE))


def in_cells(voxels: np.ndarray, side: int, corner: np.ndarray) -> Frontiers:
    """Return the cells of so many voxels along a side that hold frontier voxels (n, 3).

    A cell's place is its voxel nearest to the mean of its voxels. corner: (3,) z, y, x of the map's
    first voxel: so cells stay where they are when the map grows.
    """
    if not len(voxels):
        return Frontiers(np.zeros((0, 3), np.int64), np.zeros(0, np.int64))
    _, cell, counts = np.unique((voxels + corner) // side, axis=0, return_inverse=True, return_counts=True)
    cell = cell.reshape(-1)
    means = np.stack([np.bincount(cell, voxels[:, axis]) for axis in range(3)], axis=1) / counts[:, None]
    off = np.square(voxels - means[cell]).sum(axis=1)
    order = np.lexsort((off, cell))
    first = order[np.concatenate(([0], np.cumsum(counts)[:-1]))]
    return Frontiers(voxels[first], counts)
