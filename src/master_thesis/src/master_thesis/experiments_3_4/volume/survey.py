"""Judges the map of voxels of a flight against the world that was flown in."""

from __future__ import annotations

from pathlib import Path
from typing import Sequence

import numpy as np

from gridslam.evaluation.volume.judging import Asked, volume_metrics
from gridslam.evaluation.volume.lidars import VIEWS
from gridslam.files.tum import write_tum_in_space
from simulation_tools.geometry import Pose, quaternion_normalised

MAP, PATH, PICTURE = "map.bt", "lidar.tum", "volume.png"
"""Files in the run's folder."""


def survey_volume(
    folder: Path, world: Path | str, lidar: str, truth: np.ndarray, lidar_on_uav: np.ndarray
) -> dict:
    """Write where the lidar was and the picture of the map's errors; return the figures of the map.

    These are what `gridslam_evaluate volume map.bt WORLD --path lidar.tum --lidar LIDAR` tells.

    Args:
        folder: of the run; it has map.bt, in a frame that begins where the world's is.
        world: SDF file.
        lidar: its name; the beams of a user's own lidar are taken to be all around.
        truth: (n, 8) stamp, x, y, z, quaternion xyzw of the UAV in the world.
        lidar_on_uav: (k, 8) the same of the lidar in the UAV's frame.

    Raises:
        SlamError: map or path cannot be judged.
        OSError: a file cannot be written.
    """
    write_tum_in_space(folder / PATH, lidar_path(truth, lidar_on_uav))
    return volume_metrics(
        Asked(
            map_file=folder / MAP,
            world_file=Path(world),
            path_file=folder / PATH,
            lidar=lidar if lidar in VIEWS else None,
            picture=folder / PICTURE,
        )
    )


def lidar_path(truth: np.ndarray, lidar_on_uav: np.ndarray) -> np.ndarray:
    """Return the lidar's poses in the world (m, 8) at those of its poses on the UAV that the truth covers.

    Between two true poses, each number of the pose changes evenly.
    """
    stamps_s = lidar_on_uav[:, 0]
    within = (stamps_s >= truth[0, 0]) & (stamps_s <= truth[-1, 0]) if len(truth) else np.zeros(0, bool)
    turns = np.sum(truth[1:, 4:] * truth[:-1, 4:], axis=1)  # q and -q are one attitude
    signs = np.cumprod(np.concatenate(([1.0], np.where(turns < 0.0, -1.0, 1.0))))
    columns = np.column_stack((truth[:, 1:4], truth[:, 4:] * signs[:, None])).T
    rows = []
    for stamp_s, *mounted in lidar_on_uav[within].tolist():
        there = [float(np.interp(stamp_s, truth[:, 0], column)) for column in columns]
        lidar = _pose(there) @ _pose(mounted)
        rows.append((stamp_s, *lidar.position_m, *lidar.orientation_xyzw))
    return np.array(rows).reshape(-1, 8)


def _pose(row: Sequence[float]) -> Pose:
    return Pose((row[0], row[1], row[2]), quaternion_normalised(row[3:]))
