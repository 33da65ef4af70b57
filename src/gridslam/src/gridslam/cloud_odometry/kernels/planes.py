"""Voxels with the moments of their points, the planes through them, and points beside planes."""

from __future__ import annotations

import math

import numpy as np

from gridslam.cloud_odometry.kernels.table import EMPTY, key_of, slot_of
from kernel_cache.compiler import njit

COUNT, SUM, SQUARES, FITTED = 0, 1, 4, 10
"""Columns of moments (m, 11): number of points, their sum, sums of xx, xy, xz, yy, yz, zz in m from the
voxel's middle, and the number of points when the plane was fitted."""
MOMENTS = 11
GROWTH = 1.2
"""A plane is fitted anew when its voxel has so many times the points."""
NORMAL, MIDDLE, IS_PLANE, FROM_BEHIND, LEAN_SIGMA = 0, 3, 6, 7, 8
"""Columns of planes (m, 9): unit normal to the side from which it was seen, mean of the points in the map's
frame, 1 if it is one, how many more points that were seen from the other side lie on it than off it, and the
standard deviation of its lean, rad."""
PLANE = 9
OTHER_SIDE = 4
"""Added to the level of a voxel, it names the record of what was seen there from behind the voxel's plane."""
BEHIND_M, BEHIND_POINTS = 0.05, 5.0
"""Who is so far behind a plane does not see it, but the other side of what it belongs to. The plane of a thin
plate has two sides: of the points that were seen from behind, so many more lie so near to it than off it."""
LEVEL = 0.996
"""A plane that leans by less than 5 degrees is taken as level when it is asked who is behind it: a plane of
few points leans a little, and at a flat angle nearly all would be before it."""
FLOOR_NORMAL, FLOOR_REACH_M = 0.7, 0.15
"""A floor's normal is at least so steep: it may slope by 45 degrees. So near to it, a place is on it, m."""
FLOOR_LEVEL = 2
"""The coarsest level whose planes tell a floor's slope: wide ones follow a bend too late."""
SLOPE_SIGMAS = 2.0
"""A plane that is less sure tells neither a slope nor that the floor is level."""
SAME_SLOPE = 0.05
"""m per m: two levels that differ by less agree on a slope. A plane through few rings on floor and wall is
one of its own level only."""
WIDTH_SHARE = 0.12
"""A plane's points scatter at least this share of the voxel's side along it: a line is no plane."""


@njit(cache=True)
def _before_m(plane: np.ndarray, place: np.ndarray) -> float:
    """Return how far a place (3,) is before a plane, on the side of its normal."""
    x, y, z = place[0] - plane[MIDDLE], place[1] - plane[MIDDLE + 1], place[2] - plane[MIDDLE + 2]
    if abs(plane[NORMAL + 2]) > LEVEL:
        return z if plane[NORMAL + 2] > 0.0 else -z
    return plane[NORMAL] * x + plane[NORMAL + 1] * y + plane[NORMAL + 2] * z


@njit(cache=True)
def add_points(
    points: np.ndarray,
    origin: np.ndarray,
    levels_m: np.ndarray,
    points_min: np.ndarray,
    points_max: int,
    keys: np.ndarray,
    moments: np.ndarray,
    planes: np.ndarray,
    changed: np.ndarray,
) -> tuple[int, int]:
    """Enter points (n, 3) that were seen from an origin (3,), in the map's frame, into all levels' voxels.

    Return how many entries of ``changed`` are set, the slots of voxels whose plane is to be fitted, and how
    many voxels are new. changed: (n * levels,) int64. points_min: for each level, how many points a plane
    needs. The table must have room for as many voxels as ``changed`` has entries.
    """
    entries, new = 0, 0
    for index in range(len(points)):
        x, y, z = points[index, 0], points[index, 1], points[index, 2]
        for level in range(len(levels_m)):
            side = levels_m[level]
            i, j, k = int(np.floor(x / side)), int(np.floor(y / side)), int(np.floor(z / side))
            key = key_of(level, i, j, k)
            slot = slot_of(keys, key)
            if keys[slot] == EMPTY:
                keys[slot] = key
                new += 1
            plane = planes[slot]
            if plane[IS_PLANE] > 0.0 and _before_m(plane, origin) < -BEHIND_M:
                if abs(_before_m(plane, points[index])) <= BEHIND_M:
                    plane[FROM_BEHIND] += 1.0
                else:
                    plane[FROM_BEHIND] = max(plane[FROM_BEHIND] - 1.0, 0.0)
                    key = key_of(level + OTHER_SIDE, i, j, k)
                    slot = slot_of(keys, key)
                    if keys[slot] == EMPTY:
                        keys[slot] = key
                        new += 1
            row = moments[slot]
            if row[COUNT] >= points_max:
                continue
            u, v, w = x - (i + 0.5) * side, y - (j + 0.5) * side, z - (k + 0.5) * side
            row[COUNT] += 1.0
            row[SUM] += u
            row[SUM + 1] += v
            row[SUM + 2] += w
            row[SQUARES] += u * u
            row[SQUARES + 1] += u * v
            row[SQUARES + 2] += u * w
            row[SQUARES + 3] += v * v
            row[SQUARES + 4] += v * w
            row[SQUARES + 5] += w * w
            if row[COUNT] >= points_min[level] and row[COUNT] >= GROWTH * row[FITTED]:
                row[FITTED] = row[COUNT]
                changed[entries] = slot
                entries += 1
    return entries, new


@njit(cache=True)
def fit_planes(
    slots: np.ndarray,
    middles: np.ndarray,
    levels: np.ndarray,
    levels_m: np.ndarray,
    flatness_m: float,
    points_per_reading: float,
    origin: np.ndarray,
    moments: np.ndarray,
    planes: np.ndarray,
) -> None:
    """Fit the planes of voxels anew: the axis of least scatter of their points is the normal.

    slots: (n,). middles: (n, 3) of the voxels, m. levels: (n,). points_per_reading: so many points err
    together. origin: (3,) from which the newest points were seen.
    """
    scatter = np.empty((3, 3))
    for index in range(len(slots)):
        row, plane = moments[slots[index]], planes[slots[index]]
        level, n = levels[index], row[COUNT]
        was_plane = plane[IS_PLANE] > 0.0
        plane[IS_PLANE] = 0.0
        row[FITTED] = n
        x, y, z = row[SUM] / n, row[SUM + 1] / n, row[SUM + 2] / n
        scatter[0, 0] = row[SQUARES] / n - x * x
        scatter[0, 1] = scatter[1, 0] = row[SQUARES + 1] / n - x * y
        scatter[0, 2] = scatter[2, 0] = row[SQUARES + 2] / n - x * z
        scatter[1, 1] = row[SQUARES + 3] / n - y * y
        scatter[1, 2] = scatter[2, 1] = row[SQUARES + 4] / n - y * z
        scatter[2, 2] = row[SQUARES + 5] / n - z * z
        variances, axes = np.linalg.eigh(scatter)
        width_m = WIDTH_SHARE * levels_m[level]
        if variances[0] < flatness_m**2 and variances[1] > width_m**2:
            plane[MIDDLE] = x + middles[index, 0]
            plane[MIDDLE + 1] = y + middles[index, 1]
            plane[MIDDLE + 2] = z + middles[index, 2]
            _orient(axes[:, 0].copy(), origin, was_plane, n, plane)
            readings = max(n / points_per_reading, 1.0)
            plane[LEAN_SIGMA] = math.sqrt(max(variances[0], 0.0) / (variances[1] * readings))
            plane[IS_PLANE] = 1.0


@njit(cache=True)
def _orient(
    normal: np.ndarray, origin: np.ndarray, was_plane: bool, points: float, plane: np.ndarray
) -> None:
    """Enter a normal (3,) of a plane with its middle, to the side from which most of its points were seen."""
    turn = 0.0
    for axis in range(3):
        turn += normal[axis] * plane[NORMAL + axis]
    plane[NORMAL : NORMAL + 3] = normal
    if not was_plane:
        plane[FROM_BEHIND] = 0.0
        turn = _before_m(plane, origin)
    elif plane[FROM_BEHIND] > 0.5 * points:
        plane[FROM_BEHIND] = max(points - plane[FROM_BEHIND], 0.0)
        turn = -turn
    if turn < 0.0:
        plane[NORMAL : NORMAL + 3] = -normal


@njit(cache=True)
def _slot_seen_from(
    eye: np.ndarray, level: int, i: int, j: int, k: int, keys: np.ndarray, planes: np.ndarray
) -> int:
    """Return the slot of a voxel's plane that an eye (3,) can see; -1: there is none."""
    slot = slot_of(keys, key_of(level, i, j, k))
    if keys[slot] == EMPTY or planes[slot, IS_PLANE] == 0.0:
        return -1
    if _before_m(planes[slot], eye) >= -BEHIND_M:
        return slot
    other = slot_of(keys, key_of(level + OTHER_SIDE, i, j, k))
    if keys[other] != EMPTY and planes[other, IS_PLANE] > 0.0 and _before_m(planes[other], eye) >= -BEHIND_M:
        return other
    return slot if planes[slot, FROM_BEHIND] >= BEHIND_POINTS else -1


@njit(cache=True)
def _slope_in_level(
    place: np.ndarray,
    eye: np.ndarray,
    level: int,
    levels_m: np.ndarray,
    keys: np.ndarray,
    planes: np.ndarray,
    slope: np.ndarray,
) -> bool:
    """Set the slope (2,) of a level's plane on which a place (3,) lies; return whether there is one.

    A plane tells none that leans by less than it is uncertain, or may lean by more than a level floor.
    """
    side = levels_m[level]
    i, j, k = (
        int(np.floor(place[0] / side)),
        int(np.floor(place[1] / side)),
        int(np.floor(place[2] / side)),
    )
    slot = _slot_seen_from(eye, level, i, j, k, keys, planes)
    if slot < 0 or abs(planes[slot, NORMAL + 2]) < FLOOR_NORMAL:
        return False
    plane, off_m = planes[slot], 0.0
    for axis in range(3):
        off_m += plane[NORMAL + axis] * (place[axis] - plane[MIDDLE + axis])
    slope[0], slope[1] = -plane[NORMAL] / plane[NORMAL + 2], -plane[NORMAL + 1] / plane[NORMAL + 2]
    steep = np.hypot(slope[0], slope[1])
    is_sure = max(steep, SAME_SLOPE) > SLOPE_SIGMAS * plane[LEAN_SIGMA]
    return is_sure and abs(off_m) <= FLOOR_REACH_M


@njit(cache=True)
def _goes_on(
    place: np.ndarray,
    eye: np.ndarray,
    level: int,
    levels_m: np.ndarray,
    keys: np.ndarray,
    planes: np.ndarray,
    slope: np.ndarray,
) -> bool:
    """Return whether a floor of this slope (2,) at a place (3,) goes on, up or down, in the next voxel.

    Where it is level that is not asked. At the rim of a deck, or the edge of a hole, one plane fits the top
    and the edge. On one side of it the deck is level, on the other there is nothing.
    """
    steep = np.hypot(slope[0], slope[1])
    if steep <= SAME_SLOPE:
        return True
    beside, its_slope = np.empty(3), np.empty(2)
    for sign in (-1.0, 1.0):
        step_m = sign * levels_m[level]
        beside[0] = place[0] + step_m * slope[0] / steep
        beside[1] = place[1] + step_m * slope[1] / steep
        beside[2] = place[2] + step_m * steep
        is_floor = _slope_in_level(beside, eye, level, levels_m, keys, planes, its_slope)
        if is_floor and np.hypot(its_slope[0] - slope[0], its_slope[1] - slope[1]) < SAME_SLOPE:
            return True
    return False


@njit(cache=True)
def floor_slope(
    place: np.ndarray,
    eye: np.ndarray,
    levels_m: np.ndarray,
    keys: np.ndarray,
    planes: np.ndarray,
    slope: np.ndarray,
) -> bool:
    """Set the rise per metre along x and y (2,) of the floor at a place (3,) that is seen from an eye (3,).

    Return whether there is one: the planes of two levels on which the place lies agree, and in one of these
    levels the floor goes on beside the place. The coarsest ones up to ``FLOOR_LEVEL`` count.
    """
    other, along_x, along_y = -1, 0.0, 0.0
    for step in range(FLOOR_LEVEL + 1):
        level = FLOOR_LEVEL - step
        if not _slope_in_level(place, eye, level, levels_m, keys, planes, slope):
            continue
        if other >= 0 and np.hypot(slope[0] - along_x, slope[1] - along_y) < SAME_SLOPE:
            slope[0], slope[1] = 0.5 * (slope[0] + along_x), 0.5 * (slope[1] + along_y)
            return _goes_on(place, eye, level, levels_m, keys, planes, slope) or _goes_on(
                place, eye, other, levels_m, keys, planes, slope
            )
        other, along_x, along_y = level, slope[0], slope[1]
    return False


@njit(cache=True)
def normal_equations(
    points: np.ndarray,
    weights: np.ndarray,
    origin: np.ndarray,
    rotation: np.ndarray,
    place: np.ndarray,
    levels_m: np.ndarray,
    reach_m: float,
    keys: np.ndarray,
    planes: np.ndarray,
    information: np.ndarray,
    pull: np.ndarray,
) -> tuple[int, int]:
    """Add up points against the planes of their voxels, the finest level that has one.

    points: (n, 3) in the base frame. weights: (n,) 1/m2. origin: (3,) from which they were seen, in the base
    frame. rotation (3, 3), place (3,): base to map. Each distance e from a plane counts by Geman and
    McClure's 1 / (1 + (e / reach_m)^2)^2. Only planes that were seen from the same side count: a deck has two
    sides, as far apart as it is thick. information: (6, 6), pull: (6,): of a move and a small turn
    about the base, in the map's axes; set here. Return how many points have a plane, and how many of these
    are within the reach of it.
    """
    eye = rotation @ origin + place
    information[:] = 0.0
    pull[:] = 0.0
    found, near = 0, 0
    j = np.empty(6)
    for index in range(len(points)):
        p, q, r = points[index, 0], points[index, 1], points[index, 2]
        u = rotation[0, 0] * p + rotation[0, 1] * q + rotation[0, 2] * r
        v = rotation[1, 0] * p + rotation[1, 1] * q + rotation[1, 2] * r
        w = rotation[2, 0] * p + rotation[2, 1] * q + rotation[2, 2] * r
        x, y, z = u + place[0], v + place[1], w + place[2]
        for level in range(len(levels_m)):
            side = levels_m[level]
            column_x, column_y, layer = (
                int(np.floor(x / side)),
                int(np.floor(y / side)),
                int(np.floor(z / side)),
            )
            slot = _slot_seen_from(eye, level, column_x, column_y, layer, keys, planes)
            if slot < 0:
                continue
            plane = planes[slot]
            a, b, c = plane[NORMAL], plane[NORMAL + 1], plane[NORMAL + 2]
            e = a * (x - plane[MIDDLE]) + b * (y - plane[MIDDLE + 1]) + c * (z - plane[MIDDLE + 2])
            weight = weights[index] / (1.0 + (e / reach_m) ** 2) ** 2
            j[0], j[1], j[2] = a, b, c
            j[3] = v * c - w * b
            j[4] = w * a - u * c
            j[5] = u * b - v * a
            for row in range(6):
                pull[row] -= weight * j[row] * e
                for column in range(row, 6):
                    information[row, column] += weight * j[row] * j[column]
            found += 1
            near += abs(e) <= reach_m
            break
    for row in range(6):
        for column in range(row):
            information[row, column] = information[column, row]
    return found, near
