"""Compiles the volume's kernels ahead of the first cloud: ``python -m gridslam.volume.warm_up``."""

from __future__ import annotations

import time

import numpy as np

from gridslam.volume.clouds import Pose
from gridslam.volume.corrected_map import CorrectedMap
from gridslam.volume.correction.rebuilding import Rebuilding
from gridslam.volume.kernels.doubling import MARGIN, count_doubled
from gridslam.volume.octree.stream import map_from, stream_of
from gridslam.volume.parameters import VolumeParameters
from gridslam.volume.planning_layers import DistanceField, Frontiers
from gridslam.volume.plates import plates_of, points_of
from gridslam.volume.shown_map import ShownMap


def warm_up_volume() -> float:
    """Run a small cloud through every kernel; return the seconds that it took."""
    start = time.perf_counter()
    parameters = VolumeParameters(max_range_m=2.0)
    corrected, shown = CorrectedMap(parameters), ShownMap(parameters.resolution_m)
    points = np.array([(1.0, 0.5, 0.25), (3.0, 0.0, 0.0)], np.float32)
    corrected.add(0.0, points, Pose.identity(), Pose.identity())
    Rebuilding(corrected, [Pose.level(1.0, 0.0, 0.0)]).take_over()
    corrected.add(1.0, points, Pose.identity(), Pose.identity())
    changed = shown.refresh(corrected)
    DistanceField(parameters.resolution_m, 0.3).update(shown, changed)
    Frontiers(parameters.resolution_m).update(shown, changed)
    for octree in (shown.octree(), stream_of(corrected.voxels, is_binary=False)):
        map_from(octree.data, octree.is_binary, parameters)
    count_doubled(np.zeros((2 * MARGIN + 1,) * 3, np.uint8))
    plates_of(points_of(corrected.nodes), np.random.default_rng(1))
    return time.perf_counter() - start


if __name__ == "__main__":
    print(f"The volume's kernels are ready after {warm_up_volume():.1f} s.")
