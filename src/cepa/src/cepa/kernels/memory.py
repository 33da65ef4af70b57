"""Points that were seen, remembered in cells that are fixed to the odometry's frame."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit


@njit(cache=True)
def remember(
    points: np.ndarray, x: float, y: float, stamp: float, cell: float, xy: np.ndarray, stamps: np.ndarray
) -> None:
    """Write ``points`` (n, 2), relative to (x, y), into the cells they lie in.

    xy (n, n, 2): the newest point in each cell, m; stamps (n, n): s. The grid repeats itself: a point's cell
    is its index modulo n, so that the window follows the UAV without a copy.
    """
    n = stamps.shape[0]
    for k in range(points.shape[0]):
        px, py = points[k, 0] + x, points[k, 1] + y
        i, j = math.floor(py / cell) % n, math.floor(px / cell) % n
        xy[i, j, 0], xy[i, j, 1], stamps[i, j] = px, py, stamp


@njit(cache=True)
def recall(
    x: float,
    y: float,
    oldest: float,
    reach: float,
    bins: np.ndarray,
    gap: float,
    xy: np.ndarray,
    stamps: np.ndarray,
    points: np.ndarray,
    hidden: np.ndarray,
) -> int:
    """Fill ``points`` (m, 2) with what is remembered, relative to (x, y); return the number.

    It forgets what is older than ``oldest`` (s), farther than ``reach`` along x or y, or seen free: the bins
    of directions there reach ``gap`` beyond it. ``hidden`` (m,): whether something else stands before a
    point, or no beam looks there.
    """
    n = stamps.shape[0]
    per_rad = bins.size / (2.0 * math.pi)
    count = 0
    for i in range(n):
        for j in range(n):
            if stamps[i, j] < oldest:
                continue
            dx, dy = xy[i, j, 0] - x, xy[i, j, 1] - y
            if abs(dx) > reach or abs(dy) > reach:
                stamps[i, j] = -math.inf
                continue
            r = math.sqrt(dx * dx + dy * dy)
            b = math.floor(math.atan2(dy, dx) * per_rad + 0.5)
            least = math.inf
            most = 0.0
            blind = False
            for k in range(b - 1, b + 2):
                seen = bins[k + bins.size if k < 0 else k - bins.size if k >= bins.size else k]
                if seen < 0.0:
                    blind = True
                least = min(least, seen)
                most = max(most, seen)
            if not blind and least > r + gap:
                stamps[i, j] = -math.inf
                continue
            points[count, 0], points[count, 1] = dx, dy
            hidden[count] = blind or most < r - gap
            count += 1
            if count == points.shape[0]:
                return count
    return count
