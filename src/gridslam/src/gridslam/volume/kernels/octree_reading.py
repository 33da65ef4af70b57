"""Reads OctoMap's streams into leaves, and leaves into tiles."""

from __future__ import annotations

import numpy as np

from gridslam.volume.kernels.tiles import KEY_MAX, SIDE, SIDE_BITS, VOXELS
from kernel_cache.compiler import njit

LEVELS = 16
"""Below the root."""
IS_CUT, IS_TOO_DEEP = -1, -2


@njit(cache=True, nogil=True)
def read_leaves(
    stream: np.ndarray,
    is_binary: bool,
    free: np.float32,
    occupied: np.float32,
    corners: np.ndarray,
    sides: np.ndarray,
    values: np.ndarray,
) -> tuple[int, int]:
    """Read the leaves of a stream.

    Args:
        stream: (bytes,) uint8.
        is_binary: whether it tells free and occupied only, or each node's value.
        free: value of a free leaf of a binary stream.
        occupied: value of an occupied one.
        corners: (leaves, 3) int64 takes each leaf's least voxel, x, y, z.
        sides: (leaves,) int64 takes their sides in voxels.
        values: (leaves,) float32 takes their values. There is room for 4 leaves a byte.

    Returns:
        The number of leaves, or IS_CUT or IS_TOO_DEEP; and the number of bytes that were read.
    """
    at, count, level = 0, 0, 0
    waiting = np.zeros(LEVELS + 1, np.int64)  # a bit for each child whose turn comes, on each level
    corner = np.full((LEVELS + 1, 3), -KEY_MAX)
    word = np.empty(4, np.uint8)
    is_new = True
    while True:
        side = 2 * KEY_MAX >> level
        if is_new and is_binary:
            if at + 2 > stream.size:
                return IS_CUT, at
            bits = np.int64(stream[at]) | np.int64(stream[at + 1]) << 8
            at += 2
            waiting[level] = 0
            for child in range(8):
                code = bits >> 2 * child & 3
                if code == 3:
                    waiting[level] |= 1 << child
                elif code != 0:
                    for axis in range(3):
                        corners[count, axis] = corner[level, axis] + (child >> axis & 1) * (side >> 1)
                    sides[count], values[count] = side >> 1, (free if code == 1 else occupied)
                    count += 1
            if waiting[level] and level == LEVELS - 1:
                return IS_TOO_DEEP, at
        elif is_new:
            if at + 5 > stream.size:
                return IS_CUT, at
            for i in range(4):
                word[i] = stream[at + i]
            waiting[level] = stream[at + 4]
            at += 5
            if waiting[level] == 0:
                for axis in range(3):
                    corners[count, axis] = corner[level, axis]
                sides[count], values[count] = side, word.view(np.float32)[0]
                count += 1
            elif level == LEVELS:
                return IS_TOO_DEEP, at
        if waiting[level]:
            child = 0
            while not waiting[level] >> child & 1:
                child += 1
            waiting[level] &= ~(1 << child)
            for axis in range(3):
                corner[level + 1, axis] = corner[level, axis] + (child >> axis & 1) * (side >> 1)
            level += 1
            is_new = True
        elif level == 0:
            return count, at
        else:
            level -= 1
            is_new = False


@njit(cache=True, nogil=True)
def fill_leaves(
    corners: np.ndarray,
    sides: np.ndarray,
    values: np.ndarray,
    table: np.ndarray,
    table_corner: np.ndarray,
    log_odds: np.ndarray,
) -> None:
    """Fill the voxels of leaves; see `read_leaves`. The table (d, h, w) has a tile wherever one is needed."""
    for leaf in range(sides.size):
        side = sides[leaf]
        for z in range(corners[leaf, 2], corners[leaf, 2] + side):
            for y in range(corners[leaf, 1], corners[leaf, 1] + side):
                for x in range(corners[leaf, 0], corners[leaf, 0] + side):
                    tile = table[
                        (z >> SIDE_BITS) - table_corner[2],
                        (y >> SIDE_BITS) - table_corner[1],
                        (x >> SIDE_BITS) - table_corner[0],
                    ]
                    voxel = ((z & SIDE - 1) * SIDE + (y & SIDE - 1)) * SIDE + (x & SIDE - 1)
                    log_odds[np.int64(tile) * VOXELS + voxel] = values[leaf]
