"""Kernels of the emergency avoidance."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit

ALONGSIDE_M = 1e-9
"""What is not farther ahead than this is alongside: a direction does not lead towards it."""


@njit(cache=True)
def k_filter(ranges: np.ndarray, slope: float, increment: float) -> np.ndarray:
    """Return LS' (N,): min over j of (LS_j + slope * angle(i, j)), circular, in two passes (thesis 6.1.2)."""
    count = ranges.size
    filtered = ranges.copy()
    start = np.argmin(ranges)  # nothing can lower the least range, so that one turn each way is enough
    closing = 2.0 * math.pi - (count - 1) * increment  # angle between the last beam and the first
    for k in range(1, count):
        i = (start + k) % count
        step = closing if i == 0 else increment
        filtered[i] = min(filtered[i], filtered[i - 1] + slope * step)
    for k in range(1, count):
        i = (start - k) % count
        step = closing if i == count - 1 else increment
        filtered[i] = min(filtered[i], filtered[(i + 1) % count] + slope * step)
    return filtered


@njit(cache=True)
def emergency_edges(
    cos: np.ndarray,
    sin: np.ndarray,
    towards_x: float,
    towards_y: float,
    stopping: float,
    r_lb: float,
    body_radius: float,
) -> np.ndarray:
    """Return (N,) m: ``cushion.emergency_edge`` of every beam; ``towards``: the own velocity's direction."""
    edges = np.full(cos.size, r_lb)
    farthest = r_lb + stopping
    for j in range(cos.size):
        if cos[j] * towards_x + sin[j] * towards_y > 0.0:
            across = abs(sin[j] * towards_x - cos[j] * towards_y)
            side = body_radius / across if across * farthest > body_radius else farthest
            edges[j] = max(r_lb, side)
    return edges


@njit(cache=True)
def sum_of_intrusions(
    filtered: np.ndarray, cos: np.ndarray, sin: np.ndarray, edges: np.ndarray, increment: float
) -> tuple[float, float, float]:
    """Return (x, y, total) in m rad: the intrusions summed as vectors off the obstacles, and as lengths."""
    x = 0.0
    y = 0.0
    total = 0.0
    for i in range(filtered.size):
        depth = edges[i] - filtered[i]
        if depth > 0.0:
            x -= depth * cos[i]
            y -= depth * sin[i]
            total += depth
    return x * increment, y * increment, total * increment


@njit(cache=True)
def _blocks(ahead: float, aside: float, reading: float, radius: float, lookahead: float) -> bool:
    if ahead <= ALONGSIDE_M:
        return False
    beyond = ahead - lookahead
    if beyond <= 0.0:
        return abs(aside) <= radius or reading <= radius
    return beyond * beyond + aside * aside <= radius * radius


@njit(cache=True)
def direction_is_safe(
    ranges: np.ndarray,
    cos: np.ndarray,
    sin: np.ndarray,
    towards_x: float,
    towards_y: float,
    radius: float,
    lookahead: float,
) -> bool:
    """Tell whether nothing seen lies within ``radius`` of the first ``lookahead`` metres of a direction."""
    for j in range(ranges.size):
        if ranges[j] <= lookahead + radius:
            ahead = ranges[j] * (cos[j] * towards_x + sin[j] * towards_y)
            aside = ranges[j] * (sin[j] * towards_x - cos[j] * towards_y)
            if _blocks(ahead, aside, ranges[j], radius, lookahead):
                return False
    return True


@njit(cache=True)
def safe_directions(
    ranges: np.ndarray,
    eligible: np.ndarray,
    cos: np.ndarray,
    sin: np.ndarray,
    radius: float,
    lookahead: float,
) -> np.ndarray:
    """Return (N,) bool: ``direction_is_safe`` of every eligible beam's direction."""
    count = ranges.size
    safe = eligible.copy()
    for j in range(count):
        if ranges[j] > lookahead + radius:
            continue
        for side in (1, -1):
            width = 0 if side == 1 else 1
            while 2 * width <= count:
                ahead = ranges[j] * cos[width]
                aside = ranges[j] * sin[width]
                if not _blocks(ahead, aside, ranges[j], radius, lookahead):
                    break
                safe[(j + side * width) % count] = False
                width += 1
    return safe


@njit(cache=True)
def safe_directions_one_by_one(
    ranges: np.ndarray,
    eligible: np.ndarray,
    cos: np.ndarray,
    sin: np.ndarray,
    radius: float,
    lookahead: float,
) -> np.ndarray:
    """Return the same as ``safe_directions`` for beams that are not evenly spaced around the turn."""
    safe = eligible.copy()
    for i in range(ranges.size):
        if safe[i]:
            safe[i] = direction_is_safe(ranges, cos, sin, cos[i], sin[i], radius, lookahead)
    return safe
