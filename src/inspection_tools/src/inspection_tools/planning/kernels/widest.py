"""The widest way from what the UAV reaches to its goal: where it is too narrow."""

from __future__ import annotations

import numpy as np

from inspection_tools.planning.kernels.neighbours import STEPS
from inspection_tools.planning.kernels.search import UNREACHED
from kernel_cache.compiler import njit


@njit(cache=True, nogil=True)
def _append(first: np.ndarray, last: np.ndarray, following: np.ndarray, width: int, item: int) -> None:
    """Add a voxel to the end of the list of a width."""
    if first[width] < 0:
        first[width] = item
    else:
        following[last[width]] = item
    last[width] = item


@njit(cache=True, nogil=True)
def narrowest_place(squares: np.ndarray, came: np.ndarray, goal: np.ndarray) -> int:
    """Return the flat index of the narrowest voxel on the widest way, or -1 if no way is free.

    Voxels are visited from wide to narrow, so that each is first met on its widest way. Equally wide ones are
    visited in the order in which they are met, so that this way is short. Of equally narrow voxels on it, the
    middle one counts.

    Args:
        squares: (d, h, w) squared clearances, voxels; 0: blocked.
        came: (d, h, w) int8, of `search`: what the start reaches.
        goal: (3,) z, y, x.
    """
    depth, height, width = squares.shape
    most = int(squares.max())
    first = np.full(most + 1, -1, np.int64)  # voxels at both ends of the list of each width
    last = np.full(most + 1, -1, np.int64)
    following = np.full(squares.size, -1, np.int64)
    parents = np.full(squares.size, -2, np.int64)  # -2: not met, -1: reached by the start
    flat, reached = squares.reshape(-1), came.reshape(-1)
    for item in range(squares.size):
        if reached[item] != UNREACHED:
            parents[item] = -1
            _append(first, last, following, most, item)
    target = (goal[0] * height + goal[1]) * width + goal[2]
    level = most
    while level > 0 and parents[target] == -2:
        item = first[level]
        if item < 0:
            level -= 1
            continue
        first[level] = following[item]
        x, y, z = item % width, item // width % height, item // (width * height)
        for k in range(26):
            c, b, a = z + STEPS[k, 0], y + STEPS[k, 1], x + STEPS[k, 2]
            if not (0 <= c < depth and 0 <= b < height and 0 <= a < width):
                continue
            other = (c * height + b) * width + a
            if parents[other] == -2 and flat[other] > 0:
                parents[other] = item
                _append(first, last, following, min(level, int(flat[other])), other)
    if parents[target] == -2:
        return -1
    least, count = most, 0
    item = target
    while parents[item] >= 0:
        if flat[item] <= least:
            count = count + 1 if flat[item] == least else 1
            least = flat[item]
        item = parents[item]
    item, left = target, count // 2
    while flat[item] != least or left > 0:
        left -= flat[item] == least
        item = parents[item]
    return item
