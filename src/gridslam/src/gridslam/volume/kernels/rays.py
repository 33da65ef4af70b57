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
LANES, AHEAD = 16, 4
"""Rays that are followed side by side, and steps that each takes before its voxels are marked."""
LANE_ROWS = 9 + AHEAD
"""What is known of the lanes, row by row, float64: of x, y and z the way to the next border, from one to the
next, and the step on the board; then the places after each of the steps. A place is a whole number below
2**53, so float64 holds it."""
Y, Z, TURNS, STEPS, PLACES, LATEST = (np.uint64(row * LANES) for row in (1, 2, 3, 6, 9, LANE_ROWS - 1))


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
    least, greatest = low.astype(np.float64), high.astype(np.float64)
    for i in range(points.shape[0]):
        x, y, z = points[i, 0] - origin[0], points[i, 1] - origin[1], points[i, 2] - origin[2]
        length = np.sqrt(np.float64(x * x + y * y + z * z))
        is_cut = not (max_range < 0.0 or length <= max_range)
        by, is_inside = np.float32(length), True
        for axis in range(3):
            ends[i, axis] = points[i, axis]
            if is_cut:
                ends[i, axis] = origin[axis] + ((points[i, axis] - origin[axis]) / by) * reach
            voxel = np.floor(per_voxel * np.float64(ends[i, axis]))
            is_inside &= (voxel >= -KEY_MAX) & (voxel < KEY_MAX)  # NaN is not
        kinds[i] = LEFT_OUT if not is_inside else (CUT if is_cut else HIT)
        if is_inside:
            for axis in range(3):
                voxel = np.floor(per_voxel * np.float64(ends[i, axis]))
                least[axis], greatest[axis] = min(least[axis], voxel), max(greatest[axis], voxel)
    for axis in range(3):
        low[axis], high[axis] = np.int64(least[axis]), np.int64(greatest[axis])


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
    # Of the origin's voxel and each axis: its number, and its sides, seen from the origin, m
    first, first_border, last_border = np.empty(3), np.empty(3), np.empty(3)
    for axis in range(3):
        first[axis] = np.floor(per_voxel * np.float64(origin[axis]))
        last_border[axis] = ((first[axis] + 0.5) * resolution + half) - np.float64(origin[axis])
        first_border[axis] = ((first[axis] + 0.5) * resolution - half) - np.float64(origin[axis])
    lanes, lasts, lengths = np.zeros(LANE_ROWS * LANES), np.empty(LANES, np.uint64), np.empty(LANES)
    used, fewest = 0, 6 * KEY_MAX
    for i in range(ends.shape[0]):
        last = _place(ends[i], per_voxel, corner, stride)
        if kinds[i] == LEFT_OUT or last == start:
            continue
        x, y, z = ends[i, 0] - origin[0], ends[i, 1] - origin[1], ends[i, 2] - origin[2]
        rounded = np.float32(np.sqrt(np.float64(x * x + y * y + z * z)))
        voxels = 0
        for axis in range(3):
            way = np.float64((ends[i, axis] - origin[axis]) / rounded)
            border, turn, step = FAR, FAR, 0
            if way > 0.0:
                border, turn, step = last_border[axis] / way, resolution / way, stride[axis]
            elif way < 0.0:
                border, turn, step = first_border[axis] / way, resolution / -way, -stride[axis]
            lanes[axis * LANES + used] = border
            lanes[(3 + axis) * LANES + used] = turn
            lanes[(6 + axis) * LANES + used] = step
            voxels += int(abs(np.floor(per_voxel * np.float64(ends[i, axis])) - first[axis]))
        lanes[LATEST + np.uint64(used)] = start
        lasts[used], lengths[used] = last, rounded
        fewest = min(fewest, voxels)
        used += 1
        if used == LANES:
            _mark_lanes(lanes, lasts, lengths, fewest, board)
            used, fewest = 0, 6 * KEY_MAX
    for lane in range(np.uint64(used)):
        _mark_rest(lane, lanes, lasts[lane], lengths[lane], board)


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_lanes(
    lanes: np.ndarray, lasts: np.ndarray, lengths: np.ndarray, fewest: int, board: np.ndarray
) -> None:
    """Mark the rays of all lanes; fewest: steps from the start to the last voxel of any of them.

    A traversal ends at its last voxel, or where the next border of each axis lies behind its end. Rounding
    may hide one border of each axis from it. So it cannot end more than 3 steps before its last voxel.
    """
    start = np.uint64(np.int64(lanes[LATEST]))
    board[start >> SIX] |= ONE << (start & LOW_BITS)
    for _ in range((fewest - 4) // AHEAD):
        _step_lanes(lanes)
        for number in range(PLACES, np.uint64(LANE_ROWS * LANES)):
            place = np.uint64(np.int64(lanes[number]))
            board[place >> SIX] |= ONE << (place & LOW_BITS)
    for lane in range(np.uint64(LANES)):
        _mark_rest(lane, lanes, lasts[lane], lengths[lane], board)


@njit(cache=True, nogil=True, error_model="numpy")
def _step_lanes(lanes: np.ndarray) -> None:
    """Take AHEAD steps of each lane's traversal, as `_mark_rest` does, without a look at its end.

    There are no branches, because processors then take several lanes at once.
    """
    for lane in range(np.uint64(LANES)):
        x, y, z = lanes[lane], lanes[Y + lane], lanes[Z + lane]
        turn_x, turn_y, turn_z = lanes[TURNS + lane], lanes[TURNS + Y + lane], lanes[TURNS + Z + lane]
        step_x, step_y, step_z = lanes[STEPS + lane], lanes[STEPS + Y + lane], lanes[STEPS + Z + lane]
        place = lanes[LATEST + lane]
        for ahead in range(np.uint64(AHEAD)):
            is_z = z <= min(x, y)
            is_x = (x < y) & (not is_z)
            is_y = (not x < y) & (not is_z)
            place += (step_x if is_x else 0.0) + (step_y if is_y else 0.0) + (step_z if is_z else 0.0)
            x, y, z = x + turn_x if is_x else x, y + turn_y if is_y else y, z + turn_z if is_z else z
            lanes[PLACES + ahead * np.uint64(LANES) + lane] = place
        lanes[lane], lanes[Y + lane], lanes[Z + lane] = x, y, z


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _mark_rest(lane: int, lanes: np.ndarray, last: np.uint64, length: float, board: np.ndarray) -> None:
    """Mark the voxels of one lane's ray from its present one on."""
    x, y, z = lanes[lane], lanes[Y + lane], lanes[Z + lane]
    turn_x, turn_y, turn_z = lanes[TURNS + lane], lanes[TURNS + Y + lane], lanes[TURNS + Z + lane]
    # Without a sign, a place needs no test whether it counts from the board's end. A step back wraps around
    step_x = np.uint64(np.int64(lanes[STEPS + lane]))
    step_y = np.uint64(np.int64(lanes[STEPS + Y + lane]))
    step_z = np.uint64(np.int64(lanes[STEPS + Z + lane]))
    here = np.uint64(np.int64(lanes[LATEST + lane]))
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
