"""Where a planar lidar of short range still knows its place: near what stands at its own height."""

from __future__ import annotations

import math

import numpy as np
from scipy import ndimage

from exploration.planning.voxel_grid import OCCUPIED, VoxelGrid

LEAST_M = 1.0
"""A post does not tell enough: what counts is so long in its layer, along x or y."""
ALSO_CORNERS = np.ones((3, 3), bool)


class Landmarks:
    """How far each voxel's centre is from the nearest wall in its layer.

    A lidar that meets nothing does not tell where the UAV is. So a path may have to stay near walls.

    Args:
        grid: the map. reach_m: so far from a wall the UAV may be.
    """

    def __init__(self, grid: VoxelGrid, reach_m: float) -> None:
        self._grid, self._reach_m = grid, reach_m
        self._away_m: np.ndarray | None = None

    def note(self) -> None:
        """The map has changed."""
        self._away_m = None

    def far(self, here_m: np.ndarray) -> np.ndarray:
        """Return which voxels (d, h, w), z first, are too far away for a UAV at a place (x, y, z).

        A UAV that is too far away itself may come nearer, but not go still farther.
        """
        away_m, voxel = self._distances_m(), self._grid.index_of(here_m)
        here = math.inf if voxel is None else float(away_m[voxel])
        slack_m = math.sqrt(2.0) * self._grid.resolution_m  # from voxel to voxel on the way back
        reach_m = self._reach_m if here <= self._reach_m else here + slack_m
        far: np.ndarray = away_m > reach_m
        return far

    def _distances_m(self) -> np.ndarray:
        """Return (d, h, w); infinite in a layer without a wall."""
        kinds, voxel_m = self._grid.kinds, self._grid.resolution_m
        if self._away_m is None or self._away_m.shape != kinds.shape:
            self._away_m = np.full(kinds.shape, np.inf, np.float32)
            for layer, away_m in zip(kinds == OCCUPIED, self._away_m):
                walls = _of_length(layer, LEAST_M / voxel_m)
                if walls.any():
                    away_m[...] = ndimage.distance_transform_edt(~walls) * voxel_m
        return self._away_m


def _of_length(layer: np.ndarray, least: float) -> np.ndarray:
    """Return what is marked in a layer (h, w) and hangs together over so many voxels, along x or y."""
    numbers, _ = ndimage.label(layer, ALSO_CORNERS)
    lengths = [max(side.stop - side.start for side in found) for found in ndimage.find_objects(numbers)]
    is_long: np.ndarray = np.concatenate(([False], np.array(lengths) >= least - 1e-6))[numbers]
    return is_long
