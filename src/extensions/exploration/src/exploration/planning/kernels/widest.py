"""The widest way from what the UAV reaches to its goal: where it is too narrow."""

from __future__ import annotations

import numpy as np

from exploration.planning.kernels.heap import drop_first, push
from exploration.planning.kernels.neighbours import LENGTHS, STEPS
from exploration.planning.kernels.search import UNREACHED
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

    Voxels are visited from wide to narrow, so that each is first met on its widest way. Among the ways that
    are as wide, the one counts that keeps most room everywhere else: it is narrow only where each of them is.
    Of equally narrow voxels on it in a row, the middle one counts; of such rows, the one that the start meets
    first.

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
    least, item = most, target
    while parents[item] >= 0:
        least = min(least, int(flat[item]))
        item = parents[item]
    _keep_room(squares, reached, least, target, parents)
    return _first_row(flat, parents, target, least)


@njit(cache=True, nogil=True)
def _keep_room(
    squares: np.ndarray, reached: np.ndarray, least: int, target: int, parents: np.ndarray
) -> None:
    """Let parents lead to the target by the way that costs least, of those that are as wide as `least`.

    A voxel costs the inverse of its squared square, so that narrow ones are avoided where others lead on
    (Dijkstra, 1959).
    """
    depth, height, width = squares.shape
    flat = squares.reshape(-1)
    costs = np.full(flat.size, np.inf)
    keys, items = np.empty(1024, np.float64), np.empty(1024, np.int64)
    size = 0
    for item in range(flat.size):
        if reached[item] != UNREACHED:
            parents[item], costs[item] = -1, 0.0
            if size == keys.size:
                keys, items = np.concatenate((keys, keys)), np.concatenate((items, items))
            push(keys, items, size, 0.0, item)
            size += 1
    while size > 0:
        cost, item = keys[0], items[0]
        size -= 1
        drop_first(keys, items, size)
        if item == target:
            return
        if cost > costs[item]:
            continue
        x, y, z = item % width, item // width % height, item // (width * height)
        for k in range(26):
            c, b, a = z + STEPS[k, 0], y + STEPS[k, 1], x + STEPS[k, 2]
            if not (0 <= c < depth and 0 <= b < height and 0 <= a < width):
                continue
            other = (c * height + b) * width + a
            if flat[other] < least or reached[other] != UNREACHED:
                continue
            new = cost + LENGTHS[k] / float(flat[other]) ** 2
            if new < costs[other]:
                costs[other], parents[other] = new, item
                if size == keys.size:
                    keys, items = np.concatenate((keys, keys)), np.concatenate((items, items))
                push(keys, items, size, new, other)
                size += 1


@njit(cache=True, nogil=True)
def _first_row(flat: np.ndarray, parents: np.ndarray, target: int, least: int) -> int:
    """Return the middle of the row of voxels with this square that the way from the start meets first."""
    item, last, count, is_in_row = target, target, 0, False
    while parents[item] >= 0:  # from the target
        is_narrow = flat[item] == least
        if is_narrow and not is_in_row:
            last, count = item, 0
        count += is_narrow
        is_in_row = is_narrow
        item = parents[item]
    for _ in range(count // 2):
        last = parents[last]
    return last
