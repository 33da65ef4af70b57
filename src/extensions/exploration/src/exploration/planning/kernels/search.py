"""A* over voxels with enough clearance (Hart, Nilsson and Raphael, 1968)."""

from __future__ import annotations

import math

import numpy as np

from exploration.planning.kernels.heap import drop_first, push
from exploration.planning.kernels.neighbours import LENGTHS, STEPS, may_step
from kernel_cache.compiler import njit

UNREACHED, START, DONE = -1, 26, 32
"""In place of the number of a step, or added to it when a voxel's cost is final."""
TIE = 1.0 + 1e-7
"""Factor of the estimate: of equal costs the voxel nearer to the goal comes first. The cost errs by this."""


@njit(cache=True, nogil=True)
def _estimate(z: int, y: int, x: int, goal: tuple[int, int, int]) -> float:
    """Return the length of the shortest way by steps to neighbours, if nothing is between."""
    a, b, c = abs(z - goal[0]), abs(y - goal[1]), abs(x - goal[2])
    most, least = max(a, b, c), min(a, b, c)
    middle = a + b + c - most - least
    return least * math.sqrt(3.0) + (middle - least) * math.sqrt(2.0) + (most - middle)


@njit(cache=True, nogil=True)
def search(
    squares: np.ndarray,
    need: int,
    factors: np.ndarray,
    ends: np.ndarray,
    came: np.ndarray,
    greed: float = TIE,
) -> float:
    """Find the cheapest way. A step costs its length times the mean factor of its two voxels.

    Args:
        squares: (d, h, w) squared clearances, voxels; 0: blocked.
        need: squared clearance that the path keeps; see `may_step`.
        factors: (k,) at least 1, by squared clearance.
        ends: (2, 3) z, y, x of start and goal.
        came: (d, h, w) int8, all UNREACHED. Filled with the number of the step that led to a voxel, or START,
            plus DONE.
        greed: factor of the estimate. The way found costs at most so many times as much as the cheapest one
            (Pohl, 1970).

    Returns:
        The cost in voxels, or infinity: then `came` tells all that the start reaches.
    """
    depth, height, width = squares.shape
    clearances, steps = squares.reshape(-1), came.reshape(-1)
    goal = (ends[1, 0], ends[1, 1], ends[1, 2])
    target = (goal[0] * height + goal[1]) * width + goal[2]
    offsets = (STEPS[:, 0] * height + STEPS[:, 1]) * width + STEPS[:, 2]
    costs = np.empty(squares.size, np.float64)
    keys, items = np.empty(1024, np.float64), np.empty(1024, np.int64)
    item = (ends[0, 0] * height + ends[0, 1]) * width + ends[0, 2]
    costs[item], steps[item] = 0.0, START
    keys[0], items[0] = 0.0, item
    size = 1
    while size > 0:
        item = items[0]
        size -= 1
        drop_first(keys, items, size)
        if steps[item] >= DONE:
            continue
        steps[item] += DONE
        cost = costs[item]
        if item == target:
            return cost
        x, y, z = item % width, item // width % height, item // (width * height)
        is_inner = 0 < z < depth - 1 and 0 < y < height - 1 and 0 < x < width - 1
        here = clearances[item]
        for k in range(26):
            c, b, a = z + STEPS[k, 0], y + STEPS[k, 1], x + STEPS[k, 2]
            if not (is_inner or (0 <= c < depth and 0 <= b < height and 0 <= a < width)):
                continue
            other = item + offsets[k]
            there = clearances[other]
            if steps[other] >= DONE or not may_step(here, there, need):
                continue
            new = cost + 0.5 * LENGTHS[k] * (factors[here] + factors[there])
            if steps[other] != UNREACHED and new >= costs[other]:
                continue
            costs[other], steps[other] = new, k
            if size == keys.size:
                keys, items = np.concatenate((keys, keys)), np.concatenate((items, items))
            push(keys, items, size, new + greed * _estimate(c, b, a, goal), other)
            size += 1
    return math.inf
