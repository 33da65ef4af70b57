"""Which cells a lidar would see from which places."""

from __future__ import annotations

import math

import numpy as np

from exploration.planning.voxel_grid import FREE
from kernel_cache.compiler import njit

TOGETHER = 1e-9
"""Borders that a line crosses within this share of it are crossed at once, as at an edge or a corner."""


@njit(cache=True, nogil=True)
def is_open(kinds: np.ndarray, a: np.ndarray, b: np.ndarray) -> bool:
    """Return whether a line between two voxels' (z, y, x) centres meets free voxels only, before the last.

    The line is followed from voxel to voxel (Amanatides and Woo, 1987).
    """
    z, y, x = a[0], a[1], a[2]
    dz, dy, dx = b[0] - z, b[1] - y, b[2] - x
    each_z = 1.0 / abs(dz) if dz != 0 else math.inf
    each_y = 1.0 / abs(dy) if dy != 0 else math.inf
    each_x = 1.0 / abs(dx) if dx != 0 else math.inf
    next_z, next_y, next_x = 0.5 * each_z, 0.5 * each_y, 0.5 * each_x
    while z != b[0] or y != b[1] or x != b[2]:
        if kinds[z, y, x] != FREE:
            return False
        border = min(next_z, next_y, next_x) + TOGETHER
        if next_z <= border:
            z += 1 if dz > 0 else -1
            next_z += each_z
        if next_y <= border:
            y += 1 if dy > 0 else -1
            next_y += each_y
        if next_x <= border:
            x += 1 if dx > 0 else -1
            next_x += each_x
    return True


@njit(cache=True, nogil=True)
def has_beam(
    place: np.ndarray, cell: np.ndarray, slopes: tuple[float, float], reaches: tuple[float, float]
) -> bool:
    """Return whether a cell is within the beams and their reach, whatever is between."""
    dz = cell[0] - place[0]
    level_square = (cell[1] - place[1]) ** 2 + (cell[2] - place[2]) ** 2
    square = level_square + dz * dz
    if square > reaches[1] ** 2 or square < reaches[0] ** 2:
        return False
    level = math.sqrt(level_square)
    return slopes[0] * level - 0.5 <= dz <= slopes[1] * level + 0.5


@njit(cache=True, nogil=True)
def seen_from(
    kinds: np.ndarray,
    places: np.ndarray,
    cells: np.ndarray,
    counts: np.ndarray,
    slopes: tuple[float, float],
    reaches: tuple[float, float],
    is_seen: np.ndarray,
) -> np.ndarray:
    """Return (n,) how many frontier voxels each place shows.

    Args:
        kinds: (d, h, w) of the map.
        places: (n, 3) z, y, x of voxels.
        cells: (m, 3) those of the cells.
        counts: (m,) frontier voxels in them.
        slopes: tangents of the lowest and the highest beam's elevation.
        reaches: least and greatest distance of a view, in voxels.
        is_seen: (m,) set where any place sees a cell.
    """
    gains = np.zeros(len(places), np.int64)
    for n in range(len(places)):
        for m in range(len(cells)):
            if has_beam(places[n], cells[m], slopes, reaches) and is_open(kinds, places[n], cells[m]):
                gains[n] += counts[m]
                is_seen[m] = True
    return gains


@njit(cache=True, nogil=True)
def sights_of(
    kinds: np.ndarray,
    places: np.ndarray,
    cells: np.ndarray,
    slopes: tuple[float, float],
    reaches: tuple[float, float],
) -> np.ndarray:
    """Return (n, m) whether each place sees each cell. The arguments are those of `seen_from`."""
    sights = np.zeros((len(places), len(cells)), np.bool_)
    for n in range(len(places)):
        for m in range(len(cells)):
            if has_beam(places[n], cells[m], slopes, reaches):
                sights[n, m] = is_open(kinds, places[n], cells[m])
    return sights


@njit(cache=True, nogil=True)
def mark_seen(
    kinds: np.ndarray,
    places: np.ndarray,
    cells: np.ndarray,
    slopes: tuple[float, float],
    reaches: tuple[float, float],
    is_seen: np.ndarray,
) -> None:
    """Set is_seen (m,) where any place sees a cell. The arguments are those of `seen_from`."""
    for m in range(len(cells)):
        for n in range(len(places)):
            if is_seen[m]:
                break
            if has_beam(places[n], cells[m], slopes, reaches):
                is_seen[m] = is_open(kinds, places[n], cells[m])
