"""Finds the point of a map nearest to a beam's end, and scores a pose by such points.

Everything is in cells from the corner of the particle's table and radians. ``beams`` (n, 7) hold, in the base
frame: the beam's end x, y; a step of sqrt(2) cells along the beam, x, y; the normal of the surface that it
hit, x, y; the weight of an offset along that surface (1, like across it, if the surface is unknown).

"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gridslam.kernels.tiles import MASK, PARTS, SIDE, SIDE_BITS
from kernel_cache.compiler import njit

PART = 1.0 / PARTS
"""Cells: unit of the means."""
MARGIN = 3
"""Cells: a search may go beyond kernelSize from a beam's end by this much."""


class ParticleMap(NamedTuple):
    """The parts of a particle's map that scan matching uses; see `Tiles`."""

    table: np.ndarray
    """(h, w) the particle's tiles."""
    occupied: np.ndarray
    ends: np.ndarray
    means: np.ndarray


class NearestPoints(NamedTuple):
    """Arrays for the points of a map that are nearest to beams' ends."""

    points: np.ndarray
    """(n, 2)"""
    which: np.ndarray
    """(n,) the beam of each point."""


@njit(cache=True, nogil=True, inline="always")
def nearest(
    px: float,
    py: float,
    step_x: float,
    step_y: float,
    nx: float,
    ny: float,
    along: float,
    grid: ParticleMap,
    kernel: int,
) -> tuple[float, float, float]:
    """Return (d2, rx, ry): the offset of a beam's end from the nearest point of the map, d2 < 0 if none.

    Points are means of occupied cells within ``kernel`` cells whose neighbour towards the lidar is not
    occupied.
    """
    table, occupied, ends, means = grid
    ix, iy = int(px), int(py)
    back_x, back_y = int(px - step_x) - ix, int(py - step_y) - iy
    best, rx, ry = -1.0, 0.0, 0.0
    left, width = ix - kernel, 2 * kernel + 1
    tile_x, shift, mask = left >> SIDE_BITS, left & MASK, (1 << width) - 1
    back_left = left + back_x
    back_tile_x, back_shift = back_left >> SIDE_BITS, back_left & MASK
    for y in range(iy - kernel, iy + kernel + 1):
        tile_y, row = y >> SIDE_BITS, y & MASK
        bits = np.int64(occupied[table[tile_y, tile_x], row]) >> shift
        if shift + width > SIDE:
            bits |= np.int64(occupied[table[tile_y, tile_x + 1], row]) << (SIDE - shift)
        bits &= mask
        if bits == 0:
            continue
        tile_y, row = (y + back_y) >> SIDE_BITS, (y + back_y) & MASK
        behind = np.int64(occupied[table[tile_y, back_tile_x], row]) >> back_shift
        if back_shift + width > SIDE:
            behind |= np.int64(occupied[table[tile_y, back_tile_x + 1], row]) << (SIDE - back_shift)
        bits &= ~behind
        x = left
        while bits:
            if bits & 1:
                entry = ends[table[y >> SIDE_BITS, x >> SIDE_BITS]]
                cell = (y & MASK) * SIDE + (x & MASK)
                dx = px - x - PART * means[entry, cell, 0]
                dy = py - y - PART * means[entry, cell, 1]
                across = dx * nx + dy * ny
                d2 = across * across + along * (dx * dx + dy * dy - across * across)
                if best < 0.0 or d2 < best:
                    best, rx, ry = d2, dx, dy
            bits >>= 1
            x += 1
    return best, rx, ry


@njit(cache=True, nogil=True, inline="always")
def look(
    beams: np.ndarray, i: int, x: float, y: float, cos: float, sin: float, grid: ParticleMap, kernel: int
) -> tuple[float, float, float, float, float]:
    """Return (d2, rx, ry, px, py) of a beam: its end's offset from the map, and its end."""
    px = x + cos * beams[i, 0] - sin * beams[i, 1]
    py = y + sin * beams[i, 0] + cos * beams[i, 1]
    least = kernel + MARGIN
    most_x = (grid.table.shape[1] << SIDE_BITS) - least
    most_y = (grid.table.shape[0] << SIDE_BITS) - least
    if not (least <= px < most_x and least <= py < most_y):
        return -1.0, 0.0, 0.0, px, py
    step_x, step_y = cos * beams[i, 2] - sin * beams[i, 3], sin * beams[i, 2] + cos * beams[i, 3]
    nx, ny = cos * beams[i, 4] - sin * beams[i, 5], sin * beams[i, 4] + cos * beams[i, 5]
    d2, rx, ry = nearest(px, py, step_x, step_y, nx, ny, beams[i, 6], grid, kernel)
    return d2, rx, ry, px, py


@njit(cache=True, nogil=True)
def score(
    x: float,
    y: float,
    yaw: float,
    beams: np.ndarray,
    every: int,
    grid: ParticleMap,
    kernel: int,
    sigma: float,
    least: float,
) -> float:
    """Sum of exp(-d2 / sigma) over every ``every``-th beam with a point of the map nearby.

    The sum stops early when it cannot exceed ``least`` any more.
    """
    cos, sin = math.cos(yaw), math.sin(yaw)
    total, left = 0.0, (beams.shape[0] + every - 1) // every
    for i in range(0, beams.shape[0], every):
        if total + left <= least:
            break
        left -= 1
        d2, _, _, _, _ = look(beams, i, x, y, cos, sin, grid, kernel)
        if d2 >= 0.0:
            total += math.exp(-d2 / sigma)
    return total


@njit(cache=True, nogil=True)
def find_points(
    x: float, y: float, yaw: float, beams: np.ndarray, grid: ParticleMap, kernel: int, nearby: NearestPoints
) -> int:
    """Write the map's nearest point to each beam's end into ``nearby``; return the number of points.

    Beams without a point nearby are left out.
    """
    points, which = nearby
    cos, sin = math.cos(yaw), math.sin(yaw)
    found = 0
    for i in range(beams.shape[0]):
        d2, rx, ry, px, py = look(beams, i, x, y, cos, sin, grid, kernel)
        if d2 >= 0.0:
            points[found, 0], points[found, 1], which[found] = px - rx, py - ry, i
            found += 1
    return found


@njit(cache=True, nogil=True, inline="always")
def offset(
    x: float, y: float, cos: float, sin: float, beams: np.ndarray, i: int, point_x: float, point_y: float
) -> tuple[float, float, float, float, float, float, float]:
    """Return (rx, ry, qx, qy, nx, ny, d2): offset from a point, end from the base, normal, square."""
    qx, qy = cos * beams[i, 0] - sin * beams[i, 1], sin * beams[i, 0] + cos * beams[i, 1]
    nx, ny = cos * beams[i, 4] - sin * beams[i, 5], sin * beams[i, 4] + cos * beams[i, 5]
    rx, ry = x + qx - point_x, y + qy - point_y
    across = rx * nx + ry * ny
    return rx, ry, qx, qy, nx, ny, across * across + beams[i, 6] * (rx * rx + ry * ry - across * across)


@njit(cache=True, nogil=True)
def measure(
    x: float,
    y: float,
    yaw: float,
    beams: np.ndarray,
    nearby: NearestPoints,
    found: int,
    counts: np.ndarray,
    score_sigma: float,
    likelihood_sigma: float,
    missed: float,
) -> tuple[float, float]:
    """Return the score and the log-likelihood of a pose, by the points of `find_points`.

    The log-likelihood is the sum of -d2 / likelihood_sigma, and of ``missed`` for a beam without a point,
    over the beams that ``counts`` (n,) bool names.
    """
    points, which = nearby
    cos, sin = math.cos(yaw), math.sin(yaw)
    total, likelihood = 0.0, missed * counts.sum()
    for k in range(found):
        d2 = offset(x, y, cos, sin, beams, which[k], points[k, 0], points[k, 1])[6]
        total += math.exp(-d2 / score_sigma)
        if counts[which[k]]:
            likelihood -= missed + d2 / likelihood_sigma
    return total, likelihood
