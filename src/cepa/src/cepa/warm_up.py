"""Compile every kernel ahead of the first scan: ``python -m cepa.warm_up``.

numba keeps the compiled code beside the sources (or in NUMBA_CACHE_DIR). Later starts only load it.
"""

from __future__ import annotations

import math
import time

import numpy as np

from cepa.dynamic.cost_to_go.kernels.ways import cross_section
from cepa.dynamic.dynamic import Dynamic
from cepa.dynamic.free_space.free_ranges import FreeRanges
from cepa.dynamic.obstacle_tracks.kernels.falling import fall_rates
from cepa.dynamic.obstacle_tracks.tracker import ObstacleTracker
from cepa.dynamic.remembered.kernels.voxels import outside
from cepa.dynamic.remembered.voxel_memory import VoxelMemory
from cepa.keep_out import KeepOut, KeepOutBox
from cepa.motion import Cloud, Motion, Ranging
from cepa.parameters import CepaParameters
from cepa.scan import Beams, LaserScan2D
from cepa.thesis.improved import Improved
from cepa.thesis.original import Original

WALL_M, TRAP_M, OPEN_M = 1.0, 0.4, math.inf
WALK = 3
"""In so many scans a thing is found to move."""


def warm_up() -> float:
    """Run the thesis's algorithms through every branch that is compiled; return the seconds that it took."""
    start = time.perf_counter()
    for parameters in (CepaParameters(), CepaParameters(velocity_aware_emergency=True)):
        for scan in _scans():
            for algorithm in (Improved(parameters), Original(parameters)):
                algorithm.steer(scan, (1.0, 0.1), (1.0, 0.0))
    return time.perf_counter() - start


def warm_up_dynamic() -> float:
    """Do the same with the algorithm `dynamic`, which has most of the kernels."""
    start = time.perf_counter()
    for parameters in (CepaParameters(), CepaParameters(velocity_aware_emergency=True)):
        for scan in _scans():
            dynamic = Dynamic(parameters)
            dynamic.steer(scan, (1.0, 0.1), (1.0, 0.0))
        dynamic.view()
    climbing = Dynamic()
    climbing.take_keep_out(KeepOut([KeepOutBox((3.0, 0.0, 0.0), (4.0, 1.0, 1.0))]))
    for stamp_s, points in ((0.0, np.full((20, 3), WALL_M)), (0.1, _crowd())):
        cloud = Cloud(points, (-0.3, 0.3), 0.5, 10.0)
        motion = Motion(stamp_s, (0.0, 0.0, 2.0), (0.0, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
        climbing.steer(_wall_ahead(WALL_M), (1.0, 0.1), (1.0, 0.0), motion, cloud)
    with_ranges = Dynamic()
    with_ranges.take_ranges([Ranging((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), OPEN_M, 0.05, 10.0)])
    with_ranges.steer(_wall_ahead(WALL_M), (1.0, 0.1), (1.0, 0.0), motion)
    outside(np.zeros((3, 3)), 0.0, 0.0, 1.0)
    fall_rates(np.arange(3.0), np.zeros((3, 2)), np.empty(2), np.empty(2))
    VoxelMemory().have_stood(np.zeros((3, 3)), np.zeros(3), 0.0)
    cross_section(np.ones((9, 9)), np.ones((9, 9)), 1.0, 2.0, np.empty((9, 2), np.int64))
    free = FreeRanges(Beams(np.ones(9), np.ones(9, bool), 0.0, 0.1, 1.0), (0.0, 0.0, 0.0, 1.0), 1.0)
    tracker, side = ObstacleTracker(), np.array((0.0, 0.1, 0.2, 0.3))
    for step in range(WALK):
        thing = np.column_stack((np.full(4, 2.0), side + 0.2 * step))
        tracker.update(0.1 * step, thing, (0.0, 0.0), free)
    return time.perf_counter() - start


def _scans() -> list[LaserScan2D]:
    scans = [_wall_ahead(distance) for distance in (OPEN_M, WALL_M, TRAP_M)]
    uneven_turn = LaserScan2D(np.full(60, TRAP_M), 0.0, 2.0 * math.pi / 60.4, 0.05, 10.0)
    return [*scans, uneven_turn]


def _crowd() -> np.ndarray:
    """Return more points (n, 3), m, than the memory of clouds holds."""
    level, heights = np.arange(-7.0, 7.0, 0.15), np.arange(-0.4, 0.4, 0.05)
    points: np.ndarray = np.stack(np.meshgrid(level, level, heights), axis=-1).reshape(-1, 3)
    return points


def _wall_ahead(distance: float) -> LaserScan2D:
    angles = np.linspace(-math.pi / 2, math.pi / 2, 90)
    return LaserScan2D(distance / np.cos(angles), angles[0], angles[1] - angles[0], 0.05, 10.0)


if __name__ == "__main__":
    print(f"CEPA's kernels are ready after {warm_up() + warm_up_dynamic():.1f} s.")
