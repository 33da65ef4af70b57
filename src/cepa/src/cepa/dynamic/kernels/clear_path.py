"""Whether the reference's own path is clear: nothing near it, all of it in sight of the scan."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.kernels.angles import ANGLE_ERROR_RAD, angle_of
from cepa.dynamic.kernels.response import advance, law_of, state_of
from kernel_cache.compiler import njit


@njit(cache=True)
def is_clear(
    start: np.ndarray,
    command: np.ndarray,
    response: np.ndarray,
    commit: int,
    brake: int,
    cost: int,
    points: np.ndarray,
    ranges: np.ndarray,
    seen: np.ndarray,
    angle_0: float,
    increment: float,
    farthest: float,
    distance: float,
    radius: float,
    stride: int,
) -> bool:
    """Whether nothing is within ``distance`` of flying ``command`` (3,) on, nor of braking after the commit.

    All of both paths must lie in sight of the scan. Every ``stride``-th step is looked at. commit, brake,
    cost: see Horizon. points (n, 2 or 3): the ends of the beams, m; their height does not count. ranges, seen
    (N,): a full turn of beams. angle_0: direction of beam 0, rad. increment: rad. farthest: beyond it nothing
    counts as seen, m. radius: of the body. The arguments are loose, because numba takes microseconds to
    unpack a named tuple, and in the open this is most of what an answer needs.
    """
    law = law_of(response)
    path, count = np.empty((cost + commit + brake, 2)), 0
    for brakes in range(2):
        state = state_of(start)
        ux, uy, uz = command
        for k in range(commit + brake if brakes else cost):
            if brakes and k == commit:
                ux = uy = uz = 0.0
            state = advance(state, law, ux, uy, uz)
            if k % stride == 0:
                path[count, 0], path[count, 1] = state[0][0], state[1][0]
                count += 1
    scan = ranges, seen, angle_0, increment, farthest
    if not _is_wide_open(path[:count], scan, radius):
        for k in range(count):
            if not _is_in_sight(path[k, 0], path[k, 1], scan, radius):
                return False
    return not _is_near(path[:count], points, distance)


@njit(cache=True)
def _is_near(path: np.ndarray, points: np.ndarray, distance: float) -> bool:
    """Whether any of ``points`` (n, 2 or 3) is within ``distance`` of any place of ``path`` (m, 2)."""
    low_x, high_x = path[:, 0].min() - distance, path[:, 0].max() + distance
    low_y, high_y = path[:, 1].min() - distance, path[:, 1].max() + distance
    for j in range(points.shape[0]):
        x, y = points[j, 0], points[j, 1]
        if low_x <= x <= high_x and low_y <= y <= high_y:
            for k in range(path.shape[0]):
                if (x - path[k, 0]) ** 2 + (y - path[k, 1]) ** 2 < distance * distance:
                    return True
    return False


@njit(cache=True)
def _is_wide_open(
    path: np.ndarray, scan: tuple[np.ndarray, np.ndarray, float, float, float], radius: float
) -> bool:
    """Whether all beams around ``path`` (n, 2), m, see farther than its farthest place.

    Then `_is_in_sight` holds for each place. This test takes a fraction of the time, because it looks at each
    beam once. It does not find all paths that are in sight.
    """
    ranges, seen, angle_0, increment, farthest = scan
    error = ANGLE_ERROR_RAD / increment + 3.0  # in beams; 3 for the rounding
    middle, low, high, r_max = math.inf, 0.0, 0.0, 0.0
    for k in range(path.shape[0]):
        x, y = path[k, 0], path[k, 1]
        r = math.sqrt(x * x + y * y)
        r_max = max(r, r_max)
        if r < radius:
            continue
        angle = angle_of(x, y)
        if middle == math.inf:
            middle = angle
        offset = angle - middle
        offset -= 2.0 * math.pi * math.floor(offset / (2.0 * math.pi) + 0.5)
        width = (0.5 * math.pi * radius / r) / increment + error  # asin(q) is at most q pi / 2
        low, high = min(low, offset / increment - width), max(high, offset / increment + width)
    if middle == math.inf:
        return True
    if r_max > farthest or high - low > ranges.size - 2:
        return False
    first = math.floor((middle - angle_0) / increment + low) % ranges.size
    end, hidden = first + int(high - low) + 2, False
    for beam in range(first, min(end, ranges.size)):  # without a branch, so that several beams go at once
        hidden |= (not seen[beam]) | (ranges[beam] < r_max)
    for beam in range(end - ranges.size):
        hidden |= (not seen[beam]) | (ranges[beam] < r_max)
    return not hidden


@njit(cache=True)
def _is_in_sight(
    x: float, y: float, scan: tuple[np.ndarray, np.ndarray, float, float, float], radius: float
) -> bool:
    """Whether a disc of ``radius`` m at (x, y) is in front of all that the scan's beams show.

    scan: ranges, seen, angle_0, increment, farthest of ``is_clear``.
    """
    ranges, seen, angle_0, increment, farthest = scan
    r = math.sqrt(x * x + y * y)
    if r < radius:
        return True
    if r > farthest:
        return False
    width = int(math.asin(radius / r) / increment) + 1
    middle = math.floor((math.atan2(y, x) - angle_0) / increment + 0.5)
    first = (middle - width) % ranges.size
    end, hidden = first + 2 * width + 1, False
    for beam in range(first, min(end, ranges.size)):  # without a branch, so that several beams go at once
        hidden |= (not seen[beam]) | (ranges[beam] < r)
    for beam in range(end - ranges.size):
        hidden |= (not seen[beam]) | (ranges[beam] < r)
    return not hidden
