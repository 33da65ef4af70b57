"""A cloud as a picture in levelled axes: how far it is free in each direction.

Columns are equal bins of azimuth; rows are equal steps of the tangent of the elevation, the middle of the
picture is level. Values are horizontal distances in m. All axes are the odometry's, the lidar is the origin.
"""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.kernels.angles import ANGLE_ERROR_RAD, angle_of, column_of
from kernel_cache.compiler import njit

BLOCK = 256
"""So many points are turned before they are entered into the picture."""
LEAST_HORIZONTAL_M = 1e-3
ROUNDING = 1e-6
"""Two slopes that differ by less than this share may be the same."""


@njit(cache=True)
def level(
    points: np.ndarray,
    rotation: np.ndarray,
    range_min: float,
    range_max: float,
    row_tan: float,
    levelled: np.ndarray,
    nearest: np.ndarray,
    free: np.ndarray,
) -> int:
    """Turn ``points`` (n, 3) m of the lidar's frame into ``levelled`` (n, 3); return how many are returns.

    rotation (3, 3): of the lidar's frame into the odometry's. nearest (rows, bins), and free (r, b), a
    coarser picture: are filled with the least distance in each direction, inf where no point is. The sides of
    ``free`` divide those of ``nearest``.
    """
    rows, bins = nearest.shape
    coarse_rows = np.repeat(np.arange(free.shape[0]), rows // free.shape[0])  # divisions are slow
    coarse_columns = np.repeat(np.arange(free.shape[1]), bins // free.shape[1])
    per_rad = bins / (2.0 * math.pi)
    nearest[:], free[:] = math.inf, math.inf
    count = 0
    block, seen_at = np.empty((3, BLOCK)), np.empty((3, BLOCK))
    for first in range(0, points.shape[0], BLOCK):
        begin = count
        for k in range(first, min(points.shape[0], first + BLOCK)):
            a, b, c = float(points[k, 0]), float(points[k, 1]), float(points[k, 2])
            r2 = a * a + b * b + c * c
            if range_min * range_min <= r2 <= range_max * range_max:  # NaN fails, too
                x = rotation[0, 0] * a + rotation[0, 1] * b + rotation[0, 2] * c
                y = rotation[1, 0] * a + rotation[1, 1] * b + rotation[1, 2] * c
                z = rotation[2, 0] * a + rotation[2, 1] * b + rotation[2, 2] * c
                block[0, count - begin], block[1, count - begin], block[2, count - begin] = x, y, z
                levelled[count, 0], levelled[count, 1], levelled[count, 2] = x, y, z
                count += 1
        _place(block, count - begin, row_tan, 0.5 * rows, seen_at)
        for k in range(count - begin):
            h, row, turn = seen_at[0, k], seen_at[1, k], seen_at[2, k] * per_rad
            if h < LEAST_HORIZONTAL_M or not 0.0 <= row < rows:
                continue
            i, j = np.uint32(row), np.uint32(turn)
            if min(turn - j, j + 1.0 - turn) <= ANGLE_ERROR_RAD * per_rad:
                j = np.uint32(int((math.atan2(block[1, k], block[0, k]) + math.pi) * per_rad) % bins)
            if h < nearest[i, j]:
                nearest[i, j] = h
                m, n = coarse_rows[i], coarse_columns[j]
                free[m, n] = min(free[m, n], nearest[i, j])
    return count


@njit(cache=True, error_model="numpy")
def _place(block: np.ndarray, count: int, row_tan: float, half_rows: float, seen_at: np.ndarray) -> None:
    """Fill ``seen_at`` (3, n) with each point's distance in a plan, m, its row, and its angle from 0 on, rad.

    block (3, n): x, y and z of the first ``count`` points, m. numpy's divisions do not ask whether they
    divide by 0. So several go at once, and a point over the lidar gets a row of no meaning.
    """
    x, y, z = block[0], block[1], block[2]
    away, rows, turns = seen_at[0], seen_at[1], seen_at[2]
    for k in range(count):  # without a branch, so that several points go at once
        h = math.sqrt(x[k] * x[k] + y[k] * y[k])
        away[k], rows[k] = h, z[k] / (h * row_tan) + half_rows
        turns[k] = angle_of(x[k], y[k]) + math.pi


@njit(cache=True)
def slab_ranges(
    points: np.ndarray,
    rotation: np.ndarray,
    range_min: float,
    range_max: float,
    low: float,
    high: float,
    ranges: np.ndarray,
) -> None:
    """Shorten ``ranges`` (bins,), m, to the least distance in a plan of points between two heights.

    points (n, 3), rotation (3, 3): as in ``level``. low, high: m above the lidar.
    """
    bins = ranges.size
    per_rad = bins / (2.0 * math.pi)
    for k in range(points.shape[0]):
        a, b, c = float(points[k, 0]), float(points[k, 1]), float(points[k, 2])
        z = rotation[2, 0] * a + rotation[2, 1] * b + rotation[2, 2] * c
        if not low <= z <= high:  # NaN fails, too
            continue
        x = rotation[0, 0] * a + rotation[0, 1] * b + rotation[0, 2] * c
        y = rotation[1, 0] * a + rotation[1, 1] * b + rotation[1, 2] * c
        h = math.sqrt(x * x + y * y)
        if range_min <= h < range_max:
            column = column_of(x, y, per_rad, bins)
            if h < ranges[column]:
                ranges[column] = h


@njit(cache=True)
def open_empty(
    free: np.ndarray,
    rows_in_one: int,
    row_tan: float,
    rotation: np.ndarray,
    elevation: tuple[float, float],
    azimuth: tuple[float, float],
    no_return: float,
) -> None:
    """Tell how far the directions of ``free`` (r, b), m, are free in which no point is, and so inf stands.

    It is ``no_return`` within the lidar's field of view (``elevation`` and ``azimuth``, rad, in its own
    frame), and 0 outside. A row of ``free`` is ``rows_in_one`` rows of ``row_tan``. rotation: see ``level``.
    """
    rows, bins = free.shape
    all_around = azimuth[1] - azimuth[0] > 2.0 * math.pi * (1.0 - 2.0 / bins)
    angles = (np.arange(bins) + 0.5) * 2.0 * math.pi / bins - math.pi
    cos, sin = np.cos(angles), np.sin(angles)
    steepness = _squared_slope(elevation[0]), _squared_slope(elevation[1])
    for i in range(rows):
        up = (i + 0.5 - 0.5 * rows) * rows_in_one * row_tan
        for j in range(bins):
            if not math.isinf(free[i, j]):
                continue
            x, y = cos[j], sin[j]
            a = rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * up
            b = rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * up
            c = rotation[0, 2] * x + rotation[1, 2] * y + rotation[2, 2] * up
            looked = _is_as_steep(c, a * a + b * b, steepness, elevation)
            if looked and not all_around:
                looked = _is_between(b, a, azimuth)
            free[i, j] = no_return if looked else 0.0


@njit(cache=True, inline="always")
def _squared_slope(angle: float) -> float:
    """Return the square of an elevation's tangent, with the elevation's sign; inf from the vertical on."""
    if abs(angle) >= 0.5 * math.pi:
        return math.inf if angle > 0.0 else -math.inf
    slope = math.tan(angle)
    return slope * abs(slope)


@njit(cache=True, inline="always")
def _is_as_steep(
    c: float, squared: float, steepness: tuple[float, float], elevation: tuple[float, float]
) -> bool:
    """Whether atan2(c, sqrt(squared)) is within ``elevation``, rad; only near these it takes an arc tangent.

    steepness: `_squared_slope` of both.
    """
    own = c * abs(c)
    low, high = steepness[0] * squared, steepness[1] * squared
    if min(abs(own - low), abs(own - high)) <= ROUNDING * abs(own):
        return elevation[0] <= math.atan2(c, math.sqrt(squared)) <= elevation[1]
    return not (own < low or own > high)


@njit(cache=True, inline="always")
def _is_between(y: float, x: float, limits: tuple[float, float]) -> bool:
    """Whether atan2(y, x) is within ``limits``, rad; only near these it takes an arc tangent."""
    angle = angle_of(x, y)
    if min(abs(angle - limits[0]), abs(angle - limits[1])) <= ANGLE_ERROR_RAD:
        angle = math.atan2(y, x)
    return limits[0] <= angle <= limits[1]


@njit(cache=True)
def stamp_seen(
    free: np.ndarray,
    row_tan: float,
    origin: np.ndarray,
    stamp: float,
    oldest: float,
    cell: np.ndarray,
    reach: np.ndarray,
    own: np.ndarray,
    near: float,
    stamps: np.ndarray,
) -> None:
    """Stamp the cells that are seen free: ``stamps`` (n, n, levels) in s; indices y, x, z.

    The grid is fixed to the odometry and repeats itself. ``origin`` (3,) m: where the lidar is in it. cell:
    edge and height of a cell, m. reach: half edge and half height of the window; cells beyond are forgotten.
    own: radius of the place that counts as seen, its ends below and above the lidar, m. What was seen nearer
    than ``near``, and after ``oldest``, stays seen while it is so near.
    """
    n, levels = stamps.shape[0], stamps.shape[2]
    rows, bins = free.shape
    per_rad = bins / (2.0 * math.pi)
    first_x, first_y = math.floor(origin[0] / cell[0]) - n // 2, math.floor(origin[1] / cell[0]) - n // 2
    first_z = math.floor(origin[2] / cell[1]) - levels // 2
    heights, is_beyond = np.empty(levels), np.empty(levels, np.bool_)
    for k in range(levels):
        z = (first_z + k + 0.5) * cell[1] - origin[2]
        heights[(first_z + k) % levels], is_beyond[(first_z + k) % levels] = z, abs(z) > reach[1]
    farthest, views = np.zeros(bins), np.ascontiguousarray(free.T)
    for k in range(rows):
        for m in range(bins):
            farthest[m] = max(farthest[m], free[k, m])
    for i in range(first_y, first_y + n):
        y, plane, at = (i + 0.5) * cell[0] - origin[1], stamps[i % n], first_x % n - 1
        for j in range(first_x, first_x + n):
            x = (j + 0.5) * cell[0] - origin[0]
            at = at + 1 if at + 1 < n else 0  # j % n
            column = plane[at]
            if abs(x) > reach[0] or abs(y) > reach[0]:
                column[:] = -math.inf
                continue
            h = math.sqrt(x * x + y * y)
            b = column_of(x, y, per_rad, bins)
            if h >= near and h >= own[0] and farthest[b] <= h + 0.5 * cell[0]:  # nothing is seen there
                for m in range(levels):
                    column[m] = -math.inf if is_beyond[m] else column[m]
                continue
            per_m = 1.0 / (max(h, LEAST_HORIZONTAL_M) * row_tan)
            view, ahead = views[b], h + 0.5 * cell[0]
            stays_since, is_own = oldest if h < near else math.inf, h < own[0]
            for m in range(levels):
                z = heights[m]
                if is_beyond[m]:
                    column[m] = -math.inf
                    continue
                row = z * per_m + 0.5 * rows
                is_seen = 0.0 <= row < rows and view[np.uint32(row)] > ahead
                if is_seen or column[m] >= stays_since or (is_own and -own[1] <= z <= own[2]):
                    column[m] = stamp
