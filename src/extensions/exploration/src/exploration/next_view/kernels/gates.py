"""Where beams can enter the unknown. Late in an exploration few can; the others need not be cast."""

from __future__ import annotations

import math

import numpy as np

from exploration.planning.voxel_grid import FREE, UNKNOWN
from kernel_cache.compiler import njit

ACROSS = 0.5 * math.sqrt(2.0)
"""Voxels from a voxel's middle to its farthest edge, level."""


@njit(cache=True, nogil=True)
def mark_gates(kinds: np.ndarray, is_wall: np.ndarray, is_gate: np.ndarray) -> None:
    """Set is_gate (d, h, w) at the unknown voxels, but those of walls, that touch a free one, if by a corner.

    A beam that is looked at less than a voxel apart enters the unknown there.
    """
    depth, height, width = kinds.shape
    for z in range(depth):
        for y in range(height):
            for x in range(width):
                if kinds[z, y, x] == UNKNOWN and not is_wall[z, y, x]:
                    is_gate[z, y, x] = _touches_free(kinds, z, y, x)


@njit(cache=True, nogil=True)
def _touches_free(kinds: np.ndarray, z: int, y: int, x: int) -> bool:
    depth, height, width = kinds.shape
    for k in range(max(z - 1, 0), min(z + 2, depth)):
        for j in range(max(y - 1, 0), min(y + 2, height)):
            for i in range(max(x - 1, 0), min(x + 2, width)):
                if kinds[k, j, i] == FREE:
                    return True
    return False


@njit(cache=True, nogil=True)
def mark_ways(
    gates: np.ndarray, place: np.ndarray, slopes: tuple[float, float], far: float, is_way: np.ndarray
) -> None:
    """Set is_way (a,) at the azimuths, evenly around, in which beams from a place may meet a gate.

    Args:
        gates: (g, 3) z, y, x of voxels.
        place: (3,) of the voxel in whose middle the beams begin.
        slopes: height by level distance, of the lowest and the highest beam.
        far: length of the beams, voxels.
        is_way: (a,), false before.
    """
    around, open_ways = len(is_way), len(is_way)
    between = 2.0 * math.pi / around
    for g in range(len(gates)):
        up = float(gates[g, 0] - place[0])
        y, x = float(gates[g, 1] - place[1]), float(gates[g, 2] - place[2])
        level2 = y * y + x * x
        if level2 + up * up > (far + 1.0) ** 2:
            continue
        level = math.sqrt(level2)
        is_too_high = up - 0.5 > slopes[1] * level + ACROSS * abs(slopes[1])
        is_too_low = up + 0.5 < slopes[0] * level - ACROSS * abs(slopes[0])
        if is_too_high or is_too_low:
            continue
        half = math.pi if level <= ACROSS else math.asin(ACROSS / level)
        azimuth = math.atan2(y, x)
        first, last = math.ceil((azimuth - half) / between), math.floor((azimuth + half) / between)
        for number in range(first, min(last, first + around - 1) + 1):
            if not is_way[number % around]:
                is_way[number % around] = True
                open_ways -= 1
        if open_ways == 0:
            return
