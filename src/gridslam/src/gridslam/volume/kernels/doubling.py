"""Floors and ceilings that lie doubled in a block of voxels."""

from __future__ import annotations

import numpy as np

from gridslam.volume.kernels.shown import FREE, OCCUPIED
from kernel_cache.compiler import njit

APART_MIN, APART_MAX = 2, 5
"""Voxels from one surface to its double. Beside each other they are one surface, drawn thick."""
PATCH_MIN = 6
"""Of the 8 columns around a voxel so many have the same surface, one layer higher or lower at most."""
MARGIN = APART_MAX + 2
"""Voxels around a block that the counting looks at."""


@njit(cache=True, nogil=True)
def count_doubled(kinds: np.ndarray) -> tuple[int, int]:
    """Return how many voxels lie on floors and ceilings, and how many of these on doubled ones.

    The voxels of a floor are occupied, and those above it free; a ceiling has free ones below. It is doubled
    if another one, that faces the same way, lies `APART_MIN` to `APART_MAX` voxels above it or below it. A
    plate that was seen from both sides faces two ways, so it is none.

    kinds: (d, h, w) uint8, z, y, x, of a block with `MARGIN` voxels around it, which do not count.
    """
    depth, height, width = kinds.shape
    surface = doubled = 0
    for z in range(MARGIN, depth - MARGIN):
        for y in range(MARGIN, height - MARGIN):
            for x in range(MARGIN, width - MARGIN):
                is_surface = is_doubled = False
                for side in (-1, 1):
                    if _is_patch(kinds, z, y, x, side):
                        is_surface = True
                        for apart in range(APART_MIN, APART_MAX + 1):
                            is_doubled |= _is_patch(kinds, z - apart, y, x, side)
                            is_doubled |= _is_patch(kinds, z + apart, y, x, side)
                surface += is_surface
                doubled += is_doubled
    return surface, doubled


@njit(cache=True, nogil=True)
def _is_patch(kinds: np.ndarray, z: int, y: int, x: int, side: int) -> bool:
    """Return whether a voxel and most of those around it face a side: 1 up, -1 down."""
    if not _faces(kinds, z, y, x, side):
        return False
    found = 0
    for i in range(-1, 2):
        for j in range(-1, 2):
            if i == 0 and j == 0:
                continue
            for layer in range(-1, 2):
                if _faces(kinds, z + layer, y + i, x + j, side):
                    found += 1
                    break
    return found >= PATCH_MIN


@njit(cache=True, nogil=True)
def _faces(kinds: np.ndarray, z: int, y: int, x: int, side: int) -> bool:
    return kinds[z, y, x] == OCCUPIED and kinds[z + side, y, x] == FREE
