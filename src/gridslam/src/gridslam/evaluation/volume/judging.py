"""Judges a file of voxels against a file of true surfaces."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

import numpy as np

from gridslam.errors import EvaluationError
from gridslam.evaluation.volume.lidars import VIEWS
from gridslam.evaluation.volume.surface import read_surface
from gridslam.evaluation.volume.visibility import LidarView, Places
from gridslam.evaluation.volume.volume_error import volume_error
from gridslam.evaluation.volume.voxels import voxels_of
from gridslam.files.tum import read_tum_in_space
from gridslam.volume.clouds import Pose
from gridslam.volume.octree.files import read_octree

SEED = 1
"""Of the samples that are drawn: the same files give the same figures."""
RANGE_M = 30.0
"""`max_range` of volume.launch: what lies beyond is not in the map."""


@dataclass(frozen=True)
class Asked:
    """What is to be judged. What is None is not told.

    map_file: .bt or .ot. world_file: SDF or a mesh. path_file: true poses in the world, TUM form. lidar: a
    name in `VIEWS`; or elevation_deg and field_of_view_deg describe its beams. range_m: beyond it the map
    takes nothing. lidar_at_m: the lidar's place (3,) in the poses' frame. map_in_world: x, y, z in m, yaw in
    rad. picture: file to write.
    """

    map_file: Path
    world_file: Path
    path_file: Path | None = None
    lidar: str | None = None
    elevation_deg: tuple[float, float] | None = None
    field_of_view_deg: float | None = None
    range_m: float | None = None
    lidar_at_m: Sequence[float] | None = None
    map_in_world: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    picture: Path | None = None


def volume_metrics(asked: Asked) -> dict:
    """Return the figures under the names that result files use; draw the picture.

    Raises:
        SlamError: a file cannot be used; the sentence names it.
    """
    rng = np.random.default_rng(SEED)
    x, y, z, yaw = asked.map_in_world
    turned = Pose.level(x, y, yaw)
    map_in_world = Pose(turned.rotation, np.array((x, y, z)))
    voxels = voxels_of(read_octree(asked.map_file), map_in_world, rng)
    if not len(voxels.occupied_m):
        raise EvaluationError(
            f"{asked.map_file}: no voxel of the map is occupied, so there is nothing to judge."
        )
    places = None if asked.path_file is None else read_places(asked.path_file, asked.lidar_at_m)
    surface = read_surface(asked.world_file)
    error, distances_m = volume_error(voxels, surface, rng, places, _view(asked))
    if asked.picture:
        from gridslam.evaluation.volume.volume_picture import draw_volume_error

        draw_volume_error(asked.picture, voxels, surface, error, distances_m, places)
    return error.as_dict()


def read_places(path: Path, lidar_at_m: Sequence[float] | None = None) -> Places:
    """Read where a lidar was from a TUM file with heights. lidar_at_m: (3,) of the lidar in the poses' frame.

    Raises:
        EvaluationError: the file cannot be read, or holds a planar path.
    """
    rows = read_tum_in_space(path)
    if lidar_at_m is None and not rows[:, 3].any():
        raise EvaluationError(
            f"{path}: every pose has the height 0, as a planar path has. Give poses in space, or --lidar-at."
        )
    poses = [Pose.of_quaternion(row[1:4], row[4:]) for row in rows]
    places = Places(
        np.array([each.translation for each in poses]), np.array([each.rotation for each in poses])
    )
    return places if lidar_at_m is None else places.moved(np.asarray(lidar_at_m, float))


def _view(asked: Asked) -> LidarView:
    if asked.lidar:
        view = VIEWS[asked.lidar]
        return dataclasses.replace(view, range_max_m=min(view.range_max_m, asked.range_m or RANGE_M))
    plain = LidarView()
    return LidarView(
        asked.elevation_deg or plain.elevation_deg,
        asked.field_of_view_deg or plain.field_of_view_deg,
        asked.range_m or RANGE_M,
    )
