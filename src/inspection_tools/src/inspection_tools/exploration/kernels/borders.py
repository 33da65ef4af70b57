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


@njit(cache=True, nogil=True)
def flood(is_open: np.ndarray, seeds: np.ndarray) -> np.ndarray:
    """Return (d, h, w) which open voxels are joined to seeds (n, 3) by faces, edges or corners.

    is_open: (d, h, w). A seed that is not open joins nothing.
    """
    depth, height, width = is_open.shape
    reached = np.zeros(is_open.shape, np.bool_)
    stack = np.empty(is_open.size, np.int64)
    size = 0
    for n in range(len(seeds)):
        z, y, x = seeds[n]
        if is_open[z, y, x] and not reached[z, y, x]:
            reached[z, y, x] = True
            stack[size] = (z * height + y) * width + x
            size += 1
    while size > 0:
        size -= 1
        item = stack[size]
        x, y, z = item % width, item // width % height, item // (width * height)
        for c in range(max(z - 1, 0), min(z + 2, depth)):
            for b in range(max(y - 1, 0), min(y + 2, height)):
                for a in range(max(x - 1, 0), min(x + 2, width)):
                    if is_open[c, b, a] and not reached[c, b, a]:
                        reached[c, b, a] = True
                        stack[size] = (c * height + b) * width + a
                        size += 1
    return reached
