"""What a scan shows, in equal bins of direction along the odometry's axes, and what it hides."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit

ANGLE_ERROR_RAD = 3e-4
"""Of the polynomial in ``_bin``."""


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


@njit(cache=True, inline="always")
def _bin(ahead: float, left: float, per_rad: float) -> int:
    """Return floor(atan2(left, ahead) * per_rad + 0.5); only near its steps it takes an arc tangent."""
    across, along = abs(left), abs(ahead)
    low, high = (across, along) if across < along else (along, across)
    a = low / high if high > 0.0 else 0.0
    a2 = a * a
    angle = a * (1.0 + a2 * (-0.327622764 + a2 * (0.15931422 - 0.0464964749 * a2)))
    if across > along:
        angle = 0.5 * math.pi - angle
    if ahead < 0.0:
        angle = math.pi - angle
    place = (-angle if left < 0.0 else angle) * per_rad + 0.5
    step = math.floor(place)
    if min(place - step, step + 1.0 - place) > ANGLE_ERROR_RAD * per_rad:
        return step
    return math.floor(math.atan2(left, ahead) * per_rad + 0.5)


@njit(cache=True)
def bins_of(
    ranges: np.ndarray,
    seen: np.ndarray,
    angle_0: float,
    increment: float,
    rotation: np.ndarray,
    range_max: float,
    bins: np.ndarray,
) -> None:
    """Fill ``bins`` (m,) with the least seen range in each direction, m; -1 where no beam looks."""
    m = bins.size
    per_rad = m / (2.0 * math.pi)
    reach = max(0, math.ceil(0.5 * (increment * per_rad - 1.0)))
    bins[:] = math.inf
    x, y = math.cos(angle_0 - increment), math.sin(angle_0 - increment)
    cos, sin = math.cos(increment), math.sin(increment)
    for k in range(ranges.size):
        x, y = cos * x - sin * y, sin * x + cos * y
        if not seen[k]:
            continue
        ahead = rotation[0, 0] * x + rotation[0, 1] * y
        left = rotation[1, 0] * x + rotation[1, 1] * y
        r = min(ranges[k], range_max) * math.sqrt(ahead * ahead + left * left)
        middle = _bin(ahead, left, per_rad)
        for b in range(middle - reach, middle + reach + 1):
            b = b + m if b < 0 else b - m if b >= m else b
            bins[b] = min(bins[b], r)
    for b in range(m):
        if math.isinf(bins[b]):
            bins[b] = -1.0
    for b in range(m):  # the rounding of directions may leave out single bins
        if bins[b] < 0.0 and bins[b - 1] >= 0.0 and bins[(b + 1) % m] >= 0.0:
            bins[b] = min(bins[b - 1], bins[(b + 1) % m])


@njit(cache=True, inline="always")
def _seen_by(
    x: float, y: float, frames_xy: np.ndarray, frames_bins: np.ndarray, count: int, first: int
) -> int:
    """Return an earlier scan, of ``count``, that has seen the place, or -1; ``first`` is asked first."""
    m = frames_bins.shape[1]
    per_rad = m / (2.0 * math.pi)
    for n in range(count):
        f = first + n if first + n < count else first + n - count
        dx, dy = x - frames_xy[f, 0], y - frames_xy[f, 1]
        k = _bin(dx, dy, per_rad)
        seen = frames_bins[f, k + m if k < 0 else k]
        if dx * dx + dy * dy < seen * seen and seen > 0.0:
            return f
    return -1


@njit(cache=True)
def was_seen_around(
    bins: np.ndarray,
    x: float,
    y: float,
    frames_xy: np.ndarray,
    frames_bins: np.ndarray,
    count: int,
    radius: float,
) -> bool:
    """Return whether earlier scans have seen the rim of the body where no beam looks; as `fill_blind`."""
    per_rad, scan = bins.size / (2.0 * math.pi), 0
    for b in range(bins.size):
        if bins[b] < 0.0:
            px, py = x + radius * math.cos(b / per_rad), y + radius * math.sin(b / per_rad)
            scan = _seen_by(px, py, frames_xy, frames_bins, count, scan)
            if scan < 0:
                return False
    return True


@njit(cache=True)
def fill_blind(
    bins: np.ndarray,
    x: float,
    y: float,
    frames_xy: np.ndarray,
    frames_bins: np.ndarray,
    count: int,
    step: float,
    farthest: float,
    least: float,
) -> None:
    """Fill the bins that no beam looks in with how far earlier scans have seen there, m.

    frames_xy (f, 2), frames_bins (f, m): where earlier scans were taken, and their bins; the first ``count``
    count. x, y: where the UAV is, in the same axes. least: what the own body covers.
    """
    m, scan = bins.size, 0
    per_rad = m / (2.0 * math.pi)
    for b in range(m):
        if bins[b] >= 0.0:
            continue
        cos, sin = math.cos(b / per_rad), math.sin(b / per_rad)
        r = least
        while r < farthest:
            px, py = x + (r + step) * cos, y + (r + step) * sin
            found = _seen_by(px, py, frames_xy, frames_bins, count, scan)
            if found < 0:
                break
            scan = found
            r += step
        bins[b] = r


@njit(cache=True)
def reach_in_sight(bins: np.ndarray, radius: float, sight: np.ndarray) -> None:
    """Fill ``sight`` (m,): how far a disc's centre may go in each direction in front of all that bins show.

    The disc of ``radius`` must not meet a direction beyond its range, where something may be hidden.
    """
    m = bins.size
    width = 2.0 * math.pi / m
    most = int(0.5 * math.pi / width) + 1
    cos, sin = np.empty(most), np.empty(most)
    for k in range(most):
        cos[k], sin[k] = math.cos(k * width), math.sin(k * width)
    sight[:] = bins
    for j in range(m):
        r = bins[j]
        widest = 0.5 * math.pi if r <= radius else math.asin(radius / r)
        for k in range(int(widest / width) + 1):
            s = r * sin[k]
            if s >= radius:
                break
            first = max(0.0, r * cos[k] - math.sqrt(radius * radius - s * s))
            left, right = j + k if j + k < m else j + k - m, j - k if j >= k else j - k + m
            sight[left], sight[right] = min(sight[left], first), min(sight[right], first)
