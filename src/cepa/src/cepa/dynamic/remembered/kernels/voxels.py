"""Points of clouds, remembered in cells that are fixed to the odometry's frame."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cepa.dynamic.constants.remembered import BESIDE_UP_M, PARTS_OF_A_MISS
from cepa.dynamic.kernels.angles import column_of
from kernel_cache.compiler import njit

NOBODY = -1


class Voxels(NamedTuple):
    """A list of remembered points, and where each cell's point stands in it."""

    points: np.ndarray
    """(capacity, 3) m, in the odometry's frame."""
    stamps: np.ndarray
    """(capacity,) s"""
    begun: np.ndarray
    """(capacity,) s: when a point first came into the cell, which has held one since then."""
    misses: np.ndarray
    """(capacity,) uint8: clouds in a row that saw through the point, times PARTS_OF_A_MISS."""
    slots: np.ndarray
    """(n, n, levels) int32: index into the list, or NOBODY. The grid repeats itself; indices y, x, z."""
    edge_m: float
    height_m: float


@njit(cache=True)
def _cell(voxels: Voxels, x: float, y: float, z: float) -> tuple[int, int, int]:
    n, levels = voxels.slots.shape[0], voxels.slots.shape[2]
    i, j = math.floor(y / voxels.edge_m) % n, math.floor(x / voxels.edge_m) % n
    return i, j, math.floor(z / voxels.height_m) % levels


@njit(cache=True, inline="always")
def _first(origin: float, reach: float, edge: float, n: int) -> tuple[int, int]:
    """Return the number of the first cell of a window along an axis, and its index among ``n`` cells."""
    first = math.floor((origin - reach) / edge) - 1  # 1 for the rounding
    return first, first % n


@njit(cache=True, inline="always")
def _wrapped(cell: int, n: int) -> int:
    """Return ``cell`` % ``n``. A cell of the window is from 0 to before 2 n, and needs no slow division."""
    if 0 <= cell < 2 * n:
        return cell - n if cell >= n else cell
    return cell % n  # so far from the odometry's origin that numbers have no digits left for cells


@njit(cache=True)
def remember(
    points: np.ndarray, origin: np.ndarray, stamp: float, reach: np.ndarray, voxels: Voxels, known: int
) -> tuple[int, np.ndarray]:
    """Write ``points`` (m, 3), relative to ``origin``, into their cells; return the new number of points.

    reach: half edge and half height of the window; what is beyond it is left out. ``known``: the number so
    far. The second value (r,) are the indices of points for whose cells the list had no room.
    """
    rest, left = np.empty(points.shape[0], np.int64), 0
    n, levels, edge_m, height_m = *voxels.slots.shape[1:], voxels.edge_m, voxels.height_m
    origin_x, origin_y, origin_z = origin[0], origin[1], origin[2]
    first_x, at_x = _first(origin_x, reach[0], edge_m, n)
    first_y, at_y = _first(origin_y, reach[0], edge_m, n)
    first_z, at_z = _first(origin_z, reach[1], height_m, levels)
    for k in range(points.shape[0]):
        x, y, z = float(points[k, 0]), float(points[k, 1]), float(points[k, 2])
        if abs(x) > reach[0] or abs(y) > reach[0] or abs(z) > reach[1]:
            continue
        x, y, z = x + origin_x, y + origin_y, z + origin_z
        i = _wrapped(math.floor(y / edge_m) - first_y + at_y, n)
        j = _wrapped(math.floor(x / edge_m) - first_x + at_x, n)
        m = _wrapped(math.floor(z / height_m) - first_z + at_z, levels)
        slot = voxels.slots[i, j, m]
        if slot == NOBODY:
            if known == voxels.points.shape[0]:
                rest[left] = k
                left += 1
                continue
            slot = known
            known += 1
            voxels.slots[i, j, m] = slot
            voxels.begun[slot] = stamp
        voxels.points[slot, 0], voxels.points[slot, 1], voxels.points[slot, 2] = x, y, z
        voxels.stamps[slot] = stamp
        voxels.misses[slot] = 0
    return known, rest[:left]


@njit(cache=True)
def outside(points: np.ndarray, x: float, y: float, radius: float) -> np.ndarray:
    """Return the ``points`` (m, 3) farther than ``radius`` from (x, y) in a plan, in their order."""
    kept, count = np.empty_like(points), 0
    for k in range(points.shape[0]):
        across, along = points[k, 0] - x, points[k, 1] - y
        if abs(across) > radius or abs(along) > radius or math.hypot(across, along) > radius:
            kept[count] = points[k]
            count += 1
    return kept[:count]


@njit(cache=True)
def _misses(nearest: np.ndarray, row_tan: float, x: float, y: float, z: float, h: float, gap: float) -> int:
    """Return how much the newest cloud says that a point has gone, in parts of a miss; 0: it does not.

    It is a miss if a beam through the point ends ``gap`` beyond it, and none near it before. Near the lidar,
    the rows are closer together than its channels. There a beam within BESIDE_UP_M above or below the point
    is a part of a miss.
    """
    rows, bins = nearest.shape
    per_m = 1.0 / (max(h, 1e-3) * row_tan)
    row, high = math.floor(z * per_m + 0.5 * rows), math.floor(BESIDE_UP_M * per_m)
    if not 0 < row < rows - 1:
        return 0
    column = column_of(x, y, bins / (2.0 * math.pi), bins)
    if nearest[row, column] <= h + gap:  # mostly the point itself
        return 0
    left = column - 1 if column > 0 else bins - 1
    right = column + 1 if column + 1 < bins else 0
    found = 0
    for k in range(max(0, row - high - 1), min(rows, row + high + 2)):
        least = min(nearest[k, left], nearest[k, column], nearest[k, right])
        if least <= h + gap:
            return 0
        if abs(k - row) <= high and not math.isinf(least):
            found = max(found, PARTS_OF_A_MISS if k == row else 1)
    return found


@njit(cache=True)
def _forget(voxels: Voxels, k: int, known: int) -> int:
    """Take point ``k`` off the list, and put the last one into its place; return the new number of points."""
    i, j, m = _cell(voxels, voxels.points[k, 0], voxels.points[k, 1], voxels.points[k, 2])
    voxels.slots[i, j, m] = NOBODY
    known -= 1
    if k < known:
        voxels.points[k] = voxels.points[known]
        voxels.stamps[k], voxels.misses[k] = voxels.stamps[known], voxels.misses[known]
        voxels.begun[k] = voxels.begun[known]
        i, j, m = _cell(voxels, voxels.points[k, 0], voxels.points[k, 1], voxels.points[k, 2])
        voxels.slots[i, j, m] = k
    return known


@njit(cache=True)
def recall(
    origin: np.ndarray,
    stamp: float,
    oldest: float,
    reach: np.ndarray,
    nearest: np.ndarray,
    row_tan: float,
    gap: float,
    near: float,
    misses: int,
    voxels: Voxels,
    known: int,
    points: np.ndarray,
) -> int:
    """Fill ``points`` (capacity, 3) with what is remembered, relative to ``origin``; return the number.

    It forgets what is older than ``oldest`` (s), beyond ``reach``, or seen through by ``misses`` clouds in a
    row. nearest, row_tan: the newest cloud's picture, of ``stamp``. What is nearer than ``near`` does not
    grow old.
    """
    just_before, k = np.nextafter(stamp, -math.inf), 0
    while k < known:
        x, y, z = (
            voxels.points[k, 0] - origin[0],
            voxels.points[k, 1] - origin[1],
            voxels.points[k, 2] - origin[2],
        )
        forgotten = voxels.stamps[k] < oldest or abs(x) > reach[0] or abs(y) > reach[0] or abs(z) > reach[1]
        if not forgotten and voxels.stamps[k] < stamp:
            h = math.sqrt(x * x + y * y)
            parts = _misses(nearest, row_tan, x, y, z, h, gap)
            if parts:
                voxels.misses[k] += parts
                forgotten = voxels.misses[k] >= misses * PARTS_OF_A_MISS
            elif h < near:
                voxels.stamps[k] = just_before
        if not forgotten:
            points[k, 0], points[k, 1], points[k, 2] = x, y, z
            k += 1
            continue
        known = _forget(voxels, k, known)
    return known


@njit(cache=True)
def forget_far(farthest: float, voxels: Voxels, known: int, points: np.ndarray) -> int:
    """Forget what is farther than ``farthest`` m from the axis of height; return the number of the others.

    points (capacity, 3): what ``recall`` has filled; kept in the list's order.
    """
    k = 0
    while k < known:
        if math.sqrt(points[k, 0] * points[k, 0] + points[k, 1] * points[k, 1]) <= farthest:
            k += 1
            continue
        points[k] = points[known - 1]
        known = _forget(voxels, k, known)
    return known


@njit(cache=True)
def have_stood(
    points: np.ndarray, origin: np.ndarray, before: float, apart: float, up: float, voxels: Voxels
) -> np.ndarray:
    """Return at which ``points`` (m, 3), relative to ``origin``, something has stood since ``before`` s (m,).

    It is a remembered point within ``apart`` m in the plan, at most ``up`` m higher or lower. ``apart`` is at
    most the edge of a cell.
    """
    stood = np.zeros(points.shape[0], np.bool_)
    n, levels = voxels.slots.shape[0], voxels.slots.shape[2]
    for k in range(points.shape[0]):
        x, y, z = points[k, 0] + origin[0], points[k, 1] + origin[1], points[k, 2] + origin[2]
        i, j = math.floor(y / voxels.edge_m), math.floor(x / voxels.edge_m)
        for m in range(math.floor((z - up) / voxels.height_m), math.floor((z + up) / voxels.height_m) + 1):
            for cell in range(9):
                slot = voxels.slots[(i + cell // 3 - 1) % n, (j + cell % 3 - 1) % n, m % levels]
                if slot == NOBODY or voxels.begun[slot] > before:
                    continue
                dx, dy = voxels.points[slot, 0] - x, voxels.points[slot, 1] - y
                if dx * dx + dy * dy <= apart * apart and abs(voxels.points[slot, 2] - z) <= up:
                    stood[k] = True
    return stood
