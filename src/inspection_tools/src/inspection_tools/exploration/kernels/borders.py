"""The border between what is free and what is unknown."""

from __future__ import annotations

import numpy as np

from inspection_tools.planning.voxel_grid import FREE, UNKNOWN
from kernel_cache.compiler import njit


@njit(cache=True, nogil=True)
def mark_border(kinds: np.ndarray, is_border: np.ndarray) -> None:
    """Set is_border (d, h, w) at the unknown voxels of kinds (d, h, w) that share a face with a free one."""
    depth, height, width = kinds.shape
    for z in range(depth):
        for y in range(height):
            for x in range(width):
                here = kinds[z, y, x]
                if x + 1 < width:
                    _mark(here, kinds[z, y, x + 1], is_border, (z, y, x), (z, y, x + 1))
                if y + 1 < height:
                    _mark(here, kinds[z, y + 1, x], is_border, (z, y, x), (z, y + 1, x))
                if z + 1 < depth:
                    _mark(here, kinds[z + 1, y, x], is_border, (z, y, x), (z + 1, y, x))


@njit(cache=True, nogil=True)
def _mark(
    here: int, there: int, is_border: np.ndarray, a: tuple[int, int, int], b: tuple[int, int, int]
) -> None:
    if here == UNKNOWN and there == FREE:
        is_border[a] = True
    elif here == FREE and there == UNKNOWN:
        is_border[b] = True
