"""Beams that stand out alone, and whether earlier scans have seen the same there."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.remembered import (
    SINGLE_ACROSS_M,
    SINGLE_ALONG_M,
    SINGLE_GAP_M,
    SINGLE_GATE_SHARE,
    SINGLE_PASSES,
    SINGLE_SHARE,
    SINGLE_THINNEST_M,
    SINGLE_WIDEST,
)
from kernel_cache.compiler import njit

REMOVED = -1.0


@njit(cache=True, inline="always")
def _next(ranges: np.ndarray, k: int, step: int) -> int:
    """Return the next beam that is not removed."""
    n = ranges.size
    for _ in range(n):
        k += step
        k = k + n if k < 0 else k - n if k >= n else k
        if ranges[k] != REMOVED:
            break
    return k


@njit(cache=True)
def steady(
    ranges: np.ndarray,
    seen: np.ndarray,
    angle_0: float,
    increment: float,
    rotation: np.ndarray,
    x: float,
    y: float,
    earlier: np.ndarray,
    counts: np.ndarray,
    newest: int,
    least: int,
) -> int:
    """Put beams that stand out alone back to their nearer neighbour, unless earlier scans confirm them.

    ranges, seen (N,): a full turn of beams; the ranges change. rotation (3, 3): of the lidar's frame into the
    odometry's. x, y: of the lidar there, m. earlier (scans, m, 2): places that stood out in the last scans,
    m; counts (scans,): how many. newest: of these scans is written with those of this scan. least: in how
    many earlier scans a thing must have been seen at least. Return how many beams were put back.
    """
    n, scans, most = ranges.size, counts.size, earlier.shape[1]
    counts[newest] = 0
    changed = 0
    for _ in range(SINGLE_PASSES):
        found = 0
        for k in range(n):
            r = ranges[k]
            if r == REMOVED or math.isinf(r) or not seen[k]:
                continue
            previous = _next(ranges, k, -1)
            before = ranges[previous] if seen[previous] else math.inf
            if not before > r + SINGLE_GAP_M:
                continue
            last, width = k, 1
            following = _next(ranges, k, 1)
            while width <= SINGLE_WIDEST and seen[following] and abs(ranges[following] - r) <= SINGLE_GAP_M:
                last, width = following, width + 1
                following = _next(ranges, last, 1)
            after = ranges[following] if seen[following] else math.inf
            if (
                width > SINGLE_WIDEST
                or not after > r + SINGLE_GAP_M
                or not (seen[previous] or seen[following])
            ):
                continue
            angle = angle_0 + k * increment
            ahead, left = r * math.cos(angle), r * math.sin(angle)
            ux = rotation[0, 0] * ahead + rotation[0, 1] * left
            uy = rotation[1, 0] * ahead + rotation[1, 1] * left
            if counts[newest] < most:
                earlier[newest, counts[newest], 0], earlier[newest, counts[newest], 1] = x + ux, y + uy
                counts[newest] += 1
            ux, uy = ux / r, uy / r
            along, across = SINGLE_ALONG_M + SINGLE_GATE_SHARE * r, SINGLE_ACROSS_M + SINGLE_GATE_SHARE * r
            matches = 0
            for s in range(scans):
                if s == newest:
                    continue
                for m in range(counts[s]):
                    dx, dy = earlier[s, m, 0] - x - r * ux, earlier[s, m, 1] - y - r * uy
                    if abs(ux * dx + uy * dy) < along and abs(ux * dy - uy * dx) < across:
                        matches += 1
                        break
            meets = min(1.0, SINGLE_THINNEST_M / (r * increment))
            if matches < max(float(least), math.ceil(SINGLE_SHARE * meets * (scans - 1))):
                ranges[k] = ranges[last] = REMOVED
                found += width
        changed += found
        if found == 0:
            break
    if changed:
        _fill(ranges, seen)
    return changed


@njit(cache=True)
def _fill(ranges: np.ndarray, seen: np.ndarray) -> None:
    """Give removed beams the nearer range of those beside them."""
    n = ranges.size
    first = _next(ranges, -1, 1)
    k = first
    while True:
        end = _next(ranges, k, 1)
        value = min(ranges[k] if seen[k] else math.inf, ranges[end] if seen[end] else math.inf)
        i = k + 1 if k + 1 < n else 0
        while i != end:
            ranges[i] = value
            i = i + 1 if i + 1 < n else 0
        k = end
        if k == first:
            return
