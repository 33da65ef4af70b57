"""Finds the surfaces that a scan hit, from the scan alone.

Points (n, 2) are beams' ends in cells, in the lidar's frame and in the order of their bearing.
"""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit

STEP_MAX = 3.0
"""Cells: neighbours closer than this are always on one surface."""
SLANT_MAX, GRAZING_MAX = 7.0, 12.0
"""Greatest distance of neighbours on one surface, as a multiple of their distance across the bearing."""
TURN_MAX = 0.1
"""rad: greatest angle between neighbours on one surface that are farther apart."""
NEIGHBOURS = 2
"""A surface is fitted to at least this many points on either side, even beyond REACH."""
REACH = 3.0
"""Cells: a surface is fitted to the points within this distance on either side."""
LINE_NEIGHBOURS = 3
POINTS_MIN = 4
"""A surface is fitted to at least this many points."""
FLATNESS_MAX = 0.03
"""Greatest ratio of a flat surface's variances across and along it."""


@njit(cache=True, nogil=True)
def thin_out(
    bearings: np.ndarray,
    ranges: np.ndarray,
    spacing: float,
    depth: float,
    out_bearings: np.ndarray,
    out_ranges: np.ndarray,
) -> int:
    """Average neighbouring beams whose ends lie within ``spacing`` and ``depth``; return the number.

    Bearings (n,) ascend; spacing and depth are in the ranges' unit. The out arrays (n,) take the means.
    """
    count, first, n = 0, 0, bearings.size
    while first < n:
        bearing, distance, last = 0.0, 0.0, first
        while (
            last < n
            and (bearings[last] - bearings[first]) * ranges[first] <= spacing
            and abs(ranges[last] - ranges[first]) <= depth
        ):
            bearing += bearings[last]
            distance += ranges[last]
            last += 1
        out_bearings[count] = bearing / (last - first)
        out_ranges[count] = distance / (last - first)
        count += 1
        first = last
    return count


@njit(cache=True, nogil=True, inline="always")
def _are_neighbours(points: np.ndarray, i: int, j: int, slant: float) -> bool:
    """Whether two successive points may lie on one surface."""
    xi, yi, xj, yj = points[i, 0], points[i, 1], points[j, 0], points[j, 1]
    distance = math.hypot(xi - xj, yi - yj)
    near = min(math.hypot(xi, yi), math.hypot(xj, yj))
    turn = abs(math.atan2(xi * yj - yi * xj, xi * xj + yi * yj))
    return distance <= STEP_MAX or (turn <= TURN_MAX and distance <= slant * turn * near)


@njit(cache=True, nogil=True)
def surface_normals(
    points: np.ndarray, along: np.ndarray, normals: np.ndarray, flat: np.ndarray, grazing: bool
) -> None:
    """Fit a line to every point and its neighbours. Write the normals (n, 2), and which points are flat (n,).

    ``along`` (n,) bool is scratch: whether a point is on one surface with the one before it. ``grazing``
    also fits what beams hardly meet, and the ends of surfaces.
    """
    n, slant = points.shape[0], GRAZING_MAX if grazing else SLANT_MAX
    for i in range(n):
        along[i] = i > 0 and _are_neighbours(points, i - 1, i, slant)
    for i in range(n):
        low, high = i, i
        while along[low] and (i - low < NEIGHBOURS or _distance(points, i, low - 1) <= REACH):
            low -= 1
        while (
            high + 1 < n
            and along[high + 1]
            and (high - i < NEIGHBOURS or _distance(points, i, high + 1) <= REACH)
        ):
            high += 1
        while grazing and high - low + 1 < POINTS_MIN and along[low]:
            low -= 1
        while grazing and high - low + 1 < POINTS_MIN and high + 1 < n and along[high + 1]:
            high += 1
        flat[i] = high - low + 1 >= POINTS_MIN and _fit(points, low, high, normals[i])
        if not flat[i]:
            normals[i, 0], normals[i, 1] = 1.0, 0.0


@njit(cache=True, nogil=True)
def line_normals(points: np.ndarray, gaps: np.ndarray, normals: np.ndarray) -> None:
    """Fit a line to each point and to up to three neighbours on both sides, nearer than its gap (n,).

    Writes the unit normals (n, 2), which point towards the lidar; NaN where there are less than four points.
    """
    n = points.shape[0]
    for i in range(n):
        number, x, y, xx, xy, yy = 0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(max(0, i - LINE_NEIGHBOURS), min(n, i + LINE_NEIGHBOURS + 1)):
            dx, dy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
            if math.hypot(dx, dy) < gaps[i]:
                number += 1
                x += dx
                y += dy
                xx += dx * dx
                xy += dx * dy
                yy += dy * dy
        if number < POINTS_MIN:
            normals[i] = math.nan
            continue
        x, y = x / number, y / number
        angle = 0.5 * math.atan2(2.0 * (xy / number - x * y), xx / number - x * x - yy / number + y * y)
        nx, ny = -math.sin(angle), math.cos(angle)
        sign = -1.0 if nx * points[i, 0] + ny * points[i, 1] > 0.0 else 1.0
        normals[i, 0], normals[i, 1] = sign * nx, sign * ny


@njit(cache=True, nogil=True, inline="always")
def _distance(points: np.ndarray, i: int, j: int) -> float:
    return math.hypot(points[i, 0] - points[j, 0], points[i, 1] - points[j, 1])


@njit(cache=True, nogil=True, inline="always")
def _fit(points: np.ndarray, low: int, high: int, normal: np.ndarray) -> bool:
    """Write the normal of the line through points low to high; return whether they are flat."""
    x, y, number = 0.0, 0.0, high - low + 1
    for k in range(low, high + 1):
        x += points[k, 0]
        y += points[k, 1]
    x, y = x / number, y / number
    xx = xy = yy = 0.0
    for k in range(low, high + 1):
        dx, dy = points[k, 0] - x, points[k, 1] - y
        xx += dx * dx
        xy += dx * dy
        yy += dy * dy
    angle = 0.5 * math.atan2(2.0 * xy, xx - yy)
    normal[0], normal[1] = -math.sin(angle), math.cos(angle)
    spread = math.hypot(0.5 * (xx - yy), xy)
    mean = 0.5 * (xx + yy)
    return mean - spread <= FLATNESS_MAX * (mean + spread)
