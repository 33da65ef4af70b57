"""The border between what is free and what is unknown, and its cells."""

from __future__ import annotations

import numpy as np

from exploration.planning.voxel_grid import FREE, UNKNOWN
from kernel_cache.compiler import njit


@njit(cache=True, nogil=True)
def border_of(kinds: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return (n, 3), z, y, x: the unknown voxels of kinds (d, h, w) that share a face with a free one.

    low, high: (3,) z, y, x of the box that they are looked for in, from and before.
    """
    depth, height, width = kinds.shape
    found, size = np.empty((1024, 3), np.int64), 0
    for z in range(low[0], high[0]):
        for y in range(low[1], high[1]):
            for x in range(low[2], high[2]):
                if kinds[z, y, x] != UNKNOWN:
                    continue
                if not (
                    (x > 0 and kinds[z, y, x - 1] == FREE)
                    or (x + 1 < width and kinds[z, y, x + 1] == FREE)
                    or (y > 0 and kinds[z, y - 1, x] == FREE)
                    or (y + 1 < height and kinds[z, y + 1, x] == FREE)
                    or (z > 0 and kinds[z - 1, y, x] == FREE)
                    or (z + 1 < depth and kinds[z + 1, y, x] == FREE)
                ):
                    continue
                if size == len(found):
                    found = np.concatenate((found, found))
                found[size, 0], found[size, 1], found[size, 2] = z, y, x
                size += 1
    return found[:size].copy()


@njit(cache=True, nogil=True)
def cells_of(voxels: np.ndarray, side: int, corner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return which voxel (m,) is nearest to the mean of those in its cell, and how many (m,) are in it.

    Cells come in the order of their places, z first. Of equally near voxels the first counts.

    Args:
        voxels: (n, 3) z, y, x; at least one.
        side: voxels along a cell.
        corner: (3,) added to the voxels; cells begin at 0 then.
    """
    low, size = np.zeros(3, np.int64), np.zeros(3, np.int64)
    for axis in range(3):
        least, most = voxels[0, axis], voxels[0, axis]
        for n in range(len(voxels)):
            least, most = min(least, voxels[n, axis]), max(most, voxels[n, axis])
        low[axis] = (least + corner[axis]) // side
        size[axis] = (most + corner[axis]) // side - low[axis] + 1
    count = size[0] * size[1] * size[2]
    numbers = np.empty(len(voxels), np.int64)
    counts, sums = np.zeros(count, np.int64), np.zeros((count, 3), np.float64)
    for n in range(len(voxels)):
        cell = 0
        for axis in range(3):
            cell = cell * size[axis] + (voxels[n, axis] + corner[axis]) // side - low[axis]
        numbers[n] = cell
        counts[cell] += 1
        for axis in range(3):
            sums[cell, axis] += voxels[n, axis]
    nearest, offs = np.full(count, -1, np.int64), np.full(count, np.inf)
    for n in range(len(voxels)):
        cell = numbers[n]
        off = 0.0
        for axis in range(3):
            apart = voxels[n, axis] - sums[cell, axis] / counts[cell]
            off += apart * apart
        if off < offs[cell]:
            nearest[cell], offs[cell] = n, off
    held = np.flatnonzero(counts)
    return nearest[held], counts[held]
