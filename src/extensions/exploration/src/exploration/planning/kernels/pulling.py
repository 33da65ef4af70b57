"""Straight legs through voxels, and string pulling: the cheapest path through some of a path's points."""

from __future__ import annotations

import math

import numpy as np

from exploration.planning.kernels.neighbours import may_step
from kernel_cache.compiler import njit

TOGETHER = 1e-9
"""Borders that a leg crosses within this share of it are crossed at once, as at an edge or a corner."""
PER_LEG = 1e-6
"""Cost of a further leg, in voxels: of equal paths that with the fewest points wins."""


@njit(cache=True, nogil=True)
def leg_cost(
    squares: np.ndarray, need: int, factors: np.ndarray, begin: np.ndarray, end: np.ndarray
) -> float:
    """Return a straight leg's cost, or infinity if it enters a voxel that it may not enter.

    Every voxel on the leg counts (Amanatides and Woo, 1987), by the rule of `may_step`.

    Args:
        squares: (d, h, w) squared clearances, voxels; 0: blocked.
        need: squared clearance that a path keeps.
        factors: (k,) cost of a voxel's length, by squared clearance.
        begin: (3,) z, y, x in voxels from the corner of the first one.
        end: (3,) likewise.
    """
    way = end - begin
    length = math.sqrt((way**2).sum())
    place = np.floor(begin).astype(np.int64)
    steps = np.zeros(3, np.int64)
    borders = np.full(3, np.inf)  # share of the leg at which it crosses the next border along an axis
    widths = np.full(3, np.inf)
    for k in range(3):
        if way[k] != 0.0:
            steps[k] = 1 if way[k] > 0.0 else -1
            ahead = place[k] + 1 if way[k] > 0.0 else place[k]
            borders[k], widths[k] = (ahead - begin[k]) / way[k], 1.0 / abs(way[k])
    here = squares[place[0], place[1], place[2]]
    if here == 0:
        return math.inf
    share, cost = 0.0, 0.0
    while True:
        border = min(borders[0], borders[1], borders[2], 1.0)
        cost += (border - share) * factors[here]
        if border >= 1.0 - TOGETHER:
            return cost * length
        share = border
        for k in range(3):
            if borders[k] <= border + TOGETHER:
                place[k] += steps[k]
                borders[k] += widths[k]
                if not 0 <= place[k] < squares.shape[k]:
                    return math.inf
        there = squares[place[0], place[1], place[2]]
        if not may_step(here, there, need):
            return math.inf
        here = there


@njit(cache=True, nogil=True)
def leg_costs(
    squares: np.ndarray, need: int, factors: np.ndarray, begins: np.ndarray, ends: np.ndarray
) -> np.ndarray:
    """Return the costs (n,) of legs between places (n, 3), as `leg_cost`; infinite outside the voxels."""
    costs = np.full(len(begins), math.inf)
    for k in range(len(begins)):
        inside = True
        for axis in range(3):
            for place in (begins[k, axis], ends[k, axis]):
                inside &= 0.0 <= place < squares.shape[axis]
        if inside:
            costs[k] = leg_cost(squares, need, factors, begins[k], ends[k])
    return costs


@njit(cache=True, nogil=True)
def pull(squares: np.ndarray, need: int, factors: np.ndarray, points: np.ndarray, window: int) -> np.ndarray:
    """Return which points (m,) the cheapest path through some of them keeps; the first and the last stay.

    points: (n, 3) as in `leg_cost`; each leg between neighbours is free. window: so many points a leg skips
        at most.
    """
    count = len(points)
    costs = np.full(count, np.inf)
    before = np.zeros(count, np.int64)
    costs[0] = 0.0
    for k in range(1, count):
        for other in range(k - 1, max(-1, k - 1 - window), -1):
            cost = costs[other] + leg_cost(squares, need, factors, points[other], points[k]) + PER_LEG
            if cost < costs[k]:
                costs[k], before[k] = cost, other
    kept = np.empty(count, np.int64)
    place, number = count - 1, 0
    while True:
        kept[number] = place
        number += 1
        if place == 0:
            return kept[:number][::-1].copy()
        place = before[place]
