"""How far is free in equal bins of direction along the odometry's axes."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.kernels.angles import bin_of
from kernel_cache.compiler import njit


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
        middle = bin_of(ahead, left, per_rad)
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
        k = bin_of(dx, dy, per_rad)
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
def reach_in_sight(bins: np.ndarray, radius: float, reach: np.ndarray) -> None:
    """Fill ``reach`` (m,): how far a disc's centre may go in each direction in front of all that bins show.

    The disc of ``radius`` must not meet a direction beyond its range, where something may be hidden.
    """
    m = bins.size
    width = 2.0 * math.pi / m
    most = int(0.5 * math.pi / width) + 1
    cos, sin = np.empty(most), np.empty(most)
    for k in range(most):
        cos[k], sin[k] = math.cos(k * width), math.sin(k * width)
    reach[:] = bins
    for j in range(m):
        r = bins[j]
        widest = 0.5 * math.pi if r <= radius else math.asin(radius / r)
        for k in range(int(widest / width) + 1):
            s = r * sin[k]
            if s >= radius:
                break
            first = max(0.0, r * cos[k] - math.sqrt(radius * radius - s * s))
            left, right = j + k if j + k < m else j + k - m, j - k if j >= k else j - k + m
            reach[left], reach[right] = min(reach[left], first), min(reach[right], first)
