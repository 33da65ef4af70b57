"""A map of voxels in the world's frame, ready to be judged."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gridslam.volume.clouds import Pose
from gridslam.volume.drawing.centres import free_centres, occupied_centres
from gridslam.volume.voxel_map import VoxelMap

FREE_VOXELS = 100_000
"""Of more free voxels about as many are drawn."""


@dataclass(frozen=True)
class Voxels:
    """Centres (n, 3) of occupied and (m, 3) of free voxels in the world's frame, and their size."""

    occupied_m: np.ndarray
    free_m: np.ndarray
    resolution_m: float
    axes: np.ndarray = field(default_factory=lambda: np.eye(3))
    """(3, 3) rotation from the voxels' axes to the world's."""


def voxels_of(voxel_map: VoxelMap, map_in_world: Pose, rng: np.random.Generator) -> Voxels:
    """Return the voxels of a map. Of many free ones some are drawn."""
    placed = [
        centres @ map_in_world.rotation.T + map_in_world.translation
        for centres in (occupied_centres(voxel_map), free_centres(voxel_map, FREE_VOXELS, rng))
    ]
    return Voxels(placed[0], placed[1], voxel_map.parameters.resolution_m, map_in_world.rotation)
