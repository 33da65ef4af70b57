"""Voxels that the rays of a cloud meet: OctoMap's traversal, rounding by rounding.

`OccupancyOcTreeBase::computeUpdate` and `OcTreeBaseImpl::computeRayKeys` of OctoMap 1.10 (after Amanatides
and Woo, 1987). Points and directions are float32; the way along a ray adds up in float64. So the same voxels
are met, also where a ray touches an edge.

The board has one bit for each voxel of a box around the cloud, row by row along x. The box is one voxel
larger than the cloud on each side, because a rounded ray may miss its last voxel by one.
"""

from __future__ import annotations

import numpy as np

from gridslam.volume.kernels.tiles import KEY_MAX
from kernel_cache.compiler import njit

LEFT_OUT, CUT, HIT = 0, 1, 2
"""A point that counts for nothing; one beyond the greatest range, whose ray is free; an occupied end."""
FAR = np.finfo(np.float64).max
SIX, LOW_BITS, ONE = np.uint64(6), np.uint64(63), np.uint64(1)


@njit(cache=True, nogil=True, error_model="numpy")
def end_rays(
    points: np.ndarray,
    origin: np.ndarray,
    per_voxel: float,
    max_range: float,
    ends: np.ndarray,
    kinds: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
) -> None:
    """Say where the ray of each point ends, and widen a box of voxels by it.

    Args:
        points: (n, 3) float32 in the map's frame.
        origin: (3,) float32 of the sensor there.
        per_voxel: voxels a metre, which is 1 / resolution.
        max_range: m; below 0: none.
        ends: (n, 3) float32 takes the ends.
        kinds: (n,) uint8 takes LEFT_OUT, CUT or HIT.
        low: (3,) int64: least voxel so far.
        high: (3,) int64: greatest voxel so far.
    """
    reach = np.float32(max_range)
    for i in range(points.shape[0]):
        x, y, z = points[i, 0] - origin[0], points[i, 1] - origin[1], points[i, 2] - origin[2]
        length = np.sqrt(np.float64(x * x + y * y + z * z))
        kinds[i] = HIT
        ends[i] = points[i]
        if not (max_range < 0.0 or length <= max_range):
            kinds[i] = CUT
            by = np.float32(length)
            ends[i, 0] = origin[0] + (x / by) * reach
            ends[i, 1] = origin[1] + (y / by) * reach
            ends[i, 2] = origin[2] + (z / by) * reach
        for axis in range(3):
            if not -KEY_MAX <= np.floor(per_voxel * np.float64(ends[i, axis])) < KEY_MAX:  # also NaN
                kinds[i] = LEFT_OUT
        if kinds[i] != LEFT_OUT:
            for axis in range(3):
                voxel = np.int64(np.floor(per_voxel * np.float64(ends[i, axis])))
                low[axis], high[axis] = min(low[axis], voxel), max(high[axis], voxel)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _place(point: np.ndarray, per_voxel: float, corner: np.ndarray, stride: np.ndarray) -> int:
    """Return the bit of a point's voxel on a board."""
    place = 0
    for axis in range(3):
        place += (np.int64(np.floor(per_voxel * np.float64(point[axis]))) - corner[axis]) * stride[axis]
    return place


@njit(cache=True, nogil=True, error_model="numpy")
def mark_ends(
    ends: np.ndarray,
    kinds: np.ndarray,
    kind: int,
    per_voxel: float,
    corner: np.ndarray,
    stride: np.ndarray,
    board: np.ndarray,
    are_first: np.ndarray,
) -> None:
    """Mark the voxels in which rays of a kind end; are_first (n,) takes which end was a voxel's first."""
    for i in range(ends.shape[0]):
        if kinds[i] == kind:
            place = np.uint64(_place(ends[i], per_voxel, corner, stride))
            bit = ONE << (place & LOW_BITS)
            are_first[i] = not board[place >> SIX] & bit
            board[place >> SIX] |= bit


@njit(cache=True, nogil=True, error_model="numpy")
def clear_ends(
    ends: np.ndarray,
    kinds: np.ndarray,
    kind: int,
    per_voxel: float,
    corner: np.ndarray,
    stride: np.ndarray,
    board: np.ndarray,
) -> None:
    """Take back what `mark_ends` has marked on an empty board."""
    for i in range(ends.shape[0]):
        if kinds[i] == kind:
            board[np.uint64(_place(ends[i], per_voxel, corner, stride)) >> SIX] = np.uint64(0)


@njit(cache=True, nogil=True, error_model="numpy")
def mark_rays(
    ends: np.ndarray,
    kinds: np.ndarray,
    origin: np.ndarray,
    resolution: float,
    corner: np.ndarray,
    stride: np.ndarray,
    board: np.ndarray,
) -> None:
    """Mark the voxels that the rays from the origin cross, without those in which they end.

    Args:
        ends: (n, 3) float32, in the map's frame.
        kinds: (n,) of `end_rays`.
        origin: (3,) float32 of the sensor.
        resolution: side of a voxel, m.
        corner: (3,) int64: voxel of the board's first bit.
        stride: (3,) int64: bits from a voxel to the next along x, y, z.
        board: (words,) uint64 of bits.
    """
    per_voxel = 1.0 / resolution
    half = np.float64(np.float32(resolution * 0.5))
    start = _place(origin, per_voxel, corner, stride)
    # Of a ray and each axis: way to the next voxel, from one to the next, and the step on the board
    border, turn, step = np.empty(3), np.empty(3), np.empty(3, np.int64)
    # Of the origin's voxel and each axis: its sides, seen from the origin, m
    first_border, last_border = np.empty(3), np.empty(3)
    for axis in range(3):
        voxel = np.floor(per_voxel * np.float64(origin[axis]))
        last_border[axis] = ((voxel + 0.5) * resolution + half) - np.float64(origin[axis])
        first_border[axis] = ((voxel + 0.5) * resolution - half) - np.float64(origin[axis])
    for i in range(ends.shape[0]):
        end = _place(ends[i], per_voxel, corner, stride)
        if kinds[i] == 0 or end == start:
            continue
        x, y, z = ends[i, 0] - origin[0], ends[i, 1] - origin[1], ends[i, 2] - origin[2]
        rounded = np.float32(np.sqrt(np.float64(x * x + y * y + z * z)))
        for axis in range(3):
            way = np.float64((ends[i, axis] - origin[axis]) / rounded)
            border[axis], turn[axis], step[axis] = FAR, FAR, 0
            if way > 0.0:
                border[axis], turn[axis], step[axis] = last_border[axis] / way, resolution / way, stride[axis]
            elif way < 0.0:
                border[axis], turn[axis], step[axis] = (
                    first_border[axis] / way,
                    resolution / -way,
                    -stride[axis],
                )
        _mark_ray(start, end, float(rounded), border, turn, step, board)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _mark_ray(
    start: int,
    end: int,
    length: float,
    border: np.ndarray,
    turn: np.ndarray,
    step: np.ndarray,
    board: np.ndarray,
) -> None:
    """Mark one ray's voxels. The arrays (3,) are as in `mark_rays`; places are bits of the board."""
    x, y, z = border[0], border[1], border[2]
    turn_x, turn_y, turn_z = turn[0], turn[1], turn[2]
    # Without a sign, a place needs no test whether it counts from the board's end. A step back wraps around
    step_x, step_y, step_z = np.uint64(step[0]), np.uint64(step[1]), np.uint64(step[2])
    here, last = np.uint64(start), np.uint64(end)
    while True:
        board[here >> SIX] |= ONE << (here & LOW_BITS)
        if x < y:
            if x < z:
                here += step_x
                x += turn_x
            else:
                here += step_z
                z += turn_z
        elif y < z:
            here += step_y
            y += turn_y
        else:
            here += step_z
            z += turn_z
        if here == last or min(min(x, y), z) > length:
            return
