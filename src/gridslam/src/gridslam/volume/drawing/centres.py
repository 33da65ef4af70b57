"""The centres of a map's voxels."""

from __future__ import annotations

from typing import Iterator

import numpy as np

from gridslam.volume.kernels.tiles import SIDE
from gridslam.volume.voxel_map import VoxelMap

AT_ONCE = 256
"""Tiles that are looked at together."""


def occupied_centres(voxels: VoxelMap) -> np.ndarray:
    """Return the centres (n, 3) of all occupied voxels in the map's frame, m."""
    found = [_centres(voxels, tiles, cubes >= 0.0) for tiles, cubes in _tiles(voxels)]
    return np.concatenate([np.empty((0, 3)), *found])


def free_centres(voxels: VoxelMap, number: int, rng: np.random.Generator) -> np.ndarray:
    """Return the centres (n, 3) of the free voxels; of more than a number, about as many are drawn."""
    total = sum(int((cubes < 0.0).sum()) for _, cubes in _tiles(voxels))
    share = min(1.0, number / max(total, 1))
    found = [
        _centres(voxels, tiles, (cubes < 0.0) & (share == 1.0 or rng.random(cubes.shape) < share))
        for tiles, cubes in _tiles(voxels)
    ]
    return np.concatenate([np.empty((0, 3)), *found])


def _tiles(voxels: VoxelMap) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield the tiles (k, 3), x, y, z from the map's origin, and their log-odds (k, VOXELS)."""
    places = voxels.known_places()
    for first in range(0, len(places), AT_ONCE):
        some = places[first : first + AT_ONCE]
        yield some[:, ::-1] + voxels.corner, voxels.pool.cubes[voxels.table[tuple(some.T)]]


def _centres(voxels: VoxelMap, tiles: np.ndarray, are_meant: np.ndarray) -> np.ndarray:
    tile, voxel = np.nonzero(are_meant)
    z, y, x = np.unravel_index(voxel, (SIDE, SIDE, SIDE))
    return (tiles[tile] * SIDE + np.stack((x, y, z), axis=1) + 0.5) * voxels.parameters.resolution_m
