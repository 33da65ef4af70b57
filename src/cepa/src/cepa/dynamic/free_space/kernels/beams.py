"""The ends of a scan's beams along the odometry's axes."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit


@njit(cache=True)
def directions_of(angle_0: float, increment: float, directions: np.ndarray) -> None:
    """Fill ``directions`` (n, 2) with the unit vectors of the beams in the lidar's frame."""
    for k in range(directions.shape[0]):
        angle = angle_0 + k * increment
        directions[k, 0], directions[k, 1] = math.cos(angle), math.sin(angle)


@njit(cache=True)
def points_of(
    ranges: np.ndarray,
    seen: np.ndarray,
    directions: np.ndarray,
    qx: float,
    qy: float,
    qz: float,
    qw: float,
    range_max: float,
    points: np.ndarray,
) -> int:
    """Fill ``points`` (n, 3) with the ends of the beams along the odometry's axes; return their number.

    directions (n, 2): of the beams. qx, qy, qz, qw: of the lidar's frame in the odometry's.
    """
    xx, xy = 1.0 - 2.0 * (qy * qy + qz * qz), 2.0 * (qx * qy - qw * qz)
    yx, yy = 2.0 * (qx * qy + qw * qz), 1.0 - 2.0 * (qx * qx + qz * qz)
    zx, zy = 2.0 * (qx * qz - qw * qy), 2.0 * (qy * qz + qw * qx)
    count = 0
    for k in range(ranges.size):
        r = ranges[k]
        if seen[k] and r < range_max:
            x, y = r * directions[k, 0], r * directions[k, 1]
            points[count, 0] = xx * x + xy * y
            points[count, 1] = yx * x + yy * y
            points[count, 2] = zx * x + zy * y
            count += 1
    return count


@njit(cache=True)
def clear_of(
    points: np.ndarray, floor: float, ceiling: float, gap: float, gap_share: float, is_clear: np.ndarray
) -> None:
    """Fill ``is_clear`` (n,) with which ``points`` (n, 3) are far from floor and ceiling, m.

    They must be so by ``gap``, and by ``gap_share`` of their horizontal distance.
    """
    for k in range(points.shape[0]):
        x, y, z = points[k]
        gap_there = gap + gap_share * math.sqrt(x * x + y * y)
        is_clear[k] = floor + gap_there < z < ceiling - gap_there
