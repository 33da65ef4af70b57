"""Points that were seen, remembered in cells that are fixed to the odometry's frame."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.free_space import LEVEL_RANGE_M
from cepa.dynamic.constants.remembered import MOST_TRUST, TRUST
from kernel_cache.compiler import njit


@njit(cache=True)
def remember(
    points: np.ndarray,
    x: float,
    y: float,
    stamp: float,
    cell: float,
    xy: np.ndarray,
    stamps: np.ndarray,
    trust: np.ndarray,
) -> None:
    """Write ``points`` (n, 3), relative to the lidar at (x, y), into the cells they lie in.

    xy (n, n, 2): the newest point in each cell, m; stamps (n, n): s; trust (n, n): how many scans may see
    past it before it is forgotten. A point that is more than LEVEL_RANGE_M above or below the lidar gains no
    trust: a lidar that leans meets the floor, and one scan that sees past it tells better. The grid repeats
    itself: a point's cell is its index modulo n, so that the window follows the UAV without a copy.
    """
    n = stamps.shape[0]
    for k in range(points.shape[0]):
        px, py = points[k, 0] + x, points[k, 1] + y
        i, j = math.floor(py / cell) % n, math.floor(px / cell) % n
        if stamps[i, j] != stamp:
            known = trust[i, j] if stamps[i, j] > -math.inf else 0
            is_level = abs(points[k, 2]) <= LEVEL_RANGE_M
            trust[i, j] = min(known + TRUST, MOST_TRUST) if is_level else max(known, 1)
        xy[i, j, 0], xy[i, j, 1], stamps[i, j] = px, py, stamp


@njit(cache=True)
def recall(
    x: float,
    y: float,
    oldest: float,
    reach: float,
    bins: np.ndarray,
    gap: float,
    patience: int,
    xy: np.ndarray,
    stamps: np.ndarray,
    trust: np.ndarray,
    points: np.ndarray,
    hidden: np.ndarray,
) -> int:
    """Fill ``points`` (m, 2) with what is remembered, relative to (x, y); return the number.

    It forgets what is older than ``oldest`` (s), farther than ``reach`` along x or y, or seen free: the bins
    of directions there reach ``gap`` beyond it, in as many scans as ``trust`` says, at most ``patience``.
    ``hidden`` (m,): whether something else stands before a point, no beam looks there, or the scan sees past
    it.
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
            is_past = not blind and least > r + gap
            if is_past:
                trust[i, j] = min(trust[i, j], patience) - 1
                if trust[i, j] <= 0:
                    stamps[i, j] = -math.inf
                    continue
            points[count, 0], points[count, 1] = dx, dy
            hidden[count] = blind or is_past or most < r - gap
            count += 1
            if count == points.shape[0]:
                return count
    return count


@njit(cache=True)
def knows_near(
    end_x: float,
    end_y: float,
    x: float,
    y: float,
    oldest: float,
    distance: float,
    cell: float,
    xy: np.ndarray,
    stamps: np.ndarray,
) -> bool:
    """Return whether anything newer than ``oldest`` (s) is remembered near the way ahead.

    Near: within ``distance`` of the straight line from (x, y) to the end, which is relative to that, m.
    """
    n = stamps.shape[0]
    first_i = math.floor((y + min(0.0, end_y) - distance) / cell)
    last_i = math.floor((y + max(0.0, end_y) + distance) / cell)
    first_j = math.floor((x + min(0.0, end_x) - distance) / cell)
    last_j = math.floor((x + max(0.0, end_x) + distance) / cell)
    length2 = end_x * end_x + end_y * end_y
    for ii in range(first_i, min(last_i, first_i + n - 1) + 1):
        i = ii % n
        for jj in range(first_j, min(last_j, first_j + n - 1) + 1):
            j = jj % n
            if stamps[i, j] < oldest:
                continue
            dx, dy = xy[i, j, 0] - x, xy[i, j, 1] - y
            share = min(1.0, max(0.0, (dx * end_x + dy * end_y) / length2)) if length2 > 0.0 else 0.0
            if (dx - share * end_x) ** 2 + (dy - share * end_y) ** 2 < distance * distance:
                return True
    return False
