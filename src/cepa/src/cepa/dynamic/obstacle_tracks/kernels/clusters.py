"""Clusters of a scan's points."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.obstacle_tracks import ADJACENT_RAD
from cepa.dynamic.obstacle_tracks.kernels.columns import (
    CUT_FIRST,
    CUT_LAST,
    END,
    FIRST,
    HIDDEN,
    MIDDLE_X,
    MIDDLE_Y,
    NOT_CUT,
    SIZE,
    SURFACE_X,
    SURFACE_Y,
    TILTED,
)
from kernel_cache.compiler import njit


@njit(cache=True)
def placed(
    points: np.ndarray,
    counts: np.ndarray,
    x: float,
    y: float,
    turn: float,
    shift_x: float,
    shift_y: float,
    corrected: np.ndarray,
) -> int:
    """Fill ``corrected`` (n, 2) with the places, m, of ``points`` (n, 2 or 3) that count; return how many.

    counts (n,) bool. The points are relative to the lidar at (x, y) in the odometry's frame. ``turn``, rad,
    about its origin and then the shift, m, correct the odometry's drift.
    """
    c, s, found = math.cos(turn), math.sin(turn), 0
    for k in range(points.shape[0]):
        if counts[k]:
            px, py = points[k, 0] + x, points[k, 1] + y
            corrected[found, 0], corrected[found, 1] = c * px - s * py + shift_x, s * px + c * py + shift_y
            found += 1
    return found


@njit(cache=True)
def segment(
    points: np.ndarray,
    pose: np.ndarray,
    bins: np.ndarray,
    level: np.ndarray,
    gap: float,
    least_points: int,
    greatest_radius: float,
    clusters: np.ndarray,
    labels: np.ndarray,
) -> int:
    """Part ``points`` (n, 2), in the order of their beams, where two are more than ``gap`` m apart.

    Fills ``clusters`` (c, CLUSTER_COLUMNS) with those that have enough points and are small enough to move,
    and ``labels`` (n,) with each point's cluster or -1; returns their number. pose (3: x, y, turn of the
    bins) and bins (m,) are the scan's, as in ``_is_free``; level (m,): how far its beams are near the lidar's
    height, m. The last and the first point are neighbours. Indices count on beyond n there.
    """
    n = points.shape[0]
    labels[:] = -1
    start = 0
    while start < n and not _apart(points, start - 1, start, gap):
        start += 1
    count, first = 0, start
    for k in range(start + 1, start + n + 1):
        if k < start + n and not _apart(points, k - 1, k % n, gap):
            continue
        if k - first >= least_points and count < clusters.shape[0]:
            cluster = clusters[count]
            _measure(points, pose, bins, level, first, k, gap, cluster)
            if cluster[SIZE] <= greatest_radius:
                for j in range(first, k):
                    labels[j % n] = count
                count += 1
        first = k
    return count


@njit(cache=True)
def _apart(points: np.ndarray, j: int, k: int, gap: float) -> bool:
    dx, dy = points[k, 0] - points[j % points.shape[0], 0], points[k, 1] - points[j % points.shape[0], 1]
    return dx * dx + dy * dy > gap * gap


@njit(cache=True)
def _measure(
    points: np.ndarray,
    pose: np.ndarray,
    bins: np.ndarray,
    level: np.ndarray,
    first: int,
    end: int,
    gap: float,
    cluster: np.ndarray,
) -> None:
    n = points.shape[0]
    a, b = first % n, (end - 1) % n
    middle_x, middle_y = 0.5 * (points[a, 0] + points[b, 0]), 0.5 * (points[a, 1] + points[b, 1])
    largest = 0.0
    for k in range(first, end):
        dx, dy = points[k % n, 0] - middle_x, points[k % n, 1] - middle_y
        largest = max(largest, dx * dx + dy * dy)
    for column, other, at in ((CUT_FIRST, (first - 1) % n, a), (CUT_LAST, end % n, b)):
        cluster[column] = NOT_CUT
        if _hides(points, pose, other, at, gap) or _exceeds(points, pose, bins, at, 0.0):
            cluster[column] = HIDDEN
        elif _exceeds(points, pose, level, at, 1.0):
            cluster[column] = TILTED
    surface = ((first + end - 1) // 2) % n
    cluster[FIRST], cluster[END] = first, end
    cluster[MIDDLE_X], cluster[MIDDLE_Y], cluster[SIZE] = middle_x, middle_y, math.sqrt(largest)
    cluster[SURFACE_X], cluster[SURFACE_Y] = points[surface, 0], points[surface, 1]


@njit(cache=True)
def _hides(points: np.ndarray, pose: np.ndarray, other: int, end: int, gap: float) -> bool:
    """Whether another cluster's point stands before the end of a cluster, next to it."""
    ox, oy = points[other, 0] - pose[0], points[other, 1] - pose[1]
    ex, ey = points[end, 0] - pose[0], points[end, 1] - pose[1]
    turn = abs(math.atan2(ox * ey - oy * ex, ox * ex + oy * ey))
    return turn < ADJACENT_RAD and math.hypot(ex, ey) - math.hypot(ox, oy) > gap


@njit(cache=True)
def _exceeds(points: np.ndarray, pose: np.ndarray, bins: np.ndarray, end: int, share: float) -> bool:
    """Whether ``share`` of the distance of a cluster's end is more than the bins near it say.

    With share 0: whether it is at the edge of what the lidar sees.
    """
    per_rad = bins.size / (2.0 * math.pi)
    dx, dy = points[end, 0] - pose[0], points[end, 1] - pose[1]
    direction = math.atan2(dy, dx) - pose[2]
    middle = math.floor(direction * per_rad + 0.5)
    least = math.inf
    for b in range(middle - 2, middle + 3):
        least = min(least, bins[b % bins.size])
    return least < share * math.hypot(dx, dy)
