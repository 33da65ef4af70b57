"""Which places surfaces surround from afar, as the bars of a lattice mast surround its middle.

A place is surrounded if it sees a surface in almost all directions to the side. Between two buildings it sees
out at both ends. What lies below does not count: beside a wall, the ground would close the other half.
"""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from inspection.survey.surface.rays import Rays

ASIDE, LEAST_ASIDE = 24, 22
"""Directions to the side, and in how many of them a surface must be seen."""
UPWARD, HIGHEST_DEG = 64, 60.0
"""Rays in each, one above the other, and how high they look: thin bars lie between two of few rays."""
CELL_M, MOST_CELLS = 1.0, 10_000
"""Side of the cubes whose middles are asked; and how many, at most: then they are larger."""
CHUNK = 2_000


def surrounded_voxels(
    triangles_m: np.ndarray, blocked: np.ndarray, corner_m: np.ndarray, voxel_m: float
) -> np.ndarray:
    """Return which voxels (d, h, w) are surrounded, by cubes of some voxels.

    blocked: (d, h, w); a cube whose middle is blocked is as those beside it. corner_m: (3,) of the voxels,
    x, y, z.
    """
    held = np.argwhere(blocked)
    found = np.zeros(blocked.shape, bool)
    if not len(held):
        return found
    low, high = held.min(axis=0), held.max(axis=0) + 1  # nothing outside the box is surrounded
    cell = max(round(CELL_M / voxel_m), 1, int(np.ceil(np.cbrt(np.prod(high - low) / MOST_CELLS))))
    axes = [np.arange(a + cell // 2, b, cell) for a, b in zip(low, high)]
    if not all(map(len, axes)):
        return found
    middles = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    asked = np.flatnonzero(~blocked[tuple(middles.T)])
    places_m = (middles[asked, ::-1] + 0.5) * voxel_m + corner_m
    inside = np.zeros(len(middles), bool)
    inside[asked] = is_surrounded(triangles_m, places_m)
    cubes = inside.reshape([len(each) for each in axes])
    is_asked = np.zeros(len(middles), bool)
    is_asked[asked] = True
    all_around = np.ones((3, 3, 3))
    cubes |= ndimage.binary_dilation(cubes, all_around) & ~is_asked.reshape(cubes.shape)
    cubes = ndimage.binary_closing(np.pad(cubes, 1), all_around)[1:-1, 1:-1, 1:-1]  # beside a gap of bars
    for axis in range(3):
        cubes = np.repeat(cubes, cell, axis=axis)
    size = np.minimum(high - low, cubes.shape)
    part = tuple(slice(a, a + s) for a, s in zip(low, size))
    found[part] = cubes[tuple(slice(s) for s in size)]
    return found


def is_surrounded(triangles_m: np.ndarray, places_m: np.ndarray) -> np.ndarray:
    """Return whether places (n, 3) see a surface in almost all directions to the side."""
    rays = Rays(triangles_m)
    aside = (np.arange(ASIDE) + 0.5) * 2.0 * np.pi / ASIDE
    upward = np.radians((np.arange(UPWARD) + 0.5) * HIGHEST_DEG / UPWARD)
    a, e = (each.ravel() for each in np.meshgrid(aside, upward, indexing="ij"))
    directions = np.column_stack((np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)))
    found = np.zeros(len(places_m), bool)
    for first in range(0, len(places_m), CHUNK):
        some = places_m[first : first + CHUNK]
        begins_m, ways = np.repeat(some, len(directions), axis=0), np.tile(directions, (len(some), 1))
        sees = np.isfinite(rays.ranges_m(begins_m, ways)).reshape(len(some), ASIDE, UPWARD).any(axis=2)
        found[first : first + CHUNK] = sees.sum(axis=1) >= LEAST_ASIDE
    return found
