"""Compile every kernel ahead of the first scan: ``python -m gridslam.warm_up``.

numba keeps what it compiles beside the sources (or in NUMBA_CACHE_DIR), so that later starts only load it.
"""

from __future__ import annotations

import dataclasses
import math
import time

import numpy as np

from gridslam.filter.grid_slam import GridSlam
from gridslam.filter.step_check import Link
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan
from gridslam.search import LikelihoodField, PlaceSearch, SearchSettings


def warm_up() -> float:
    """Run filter and search through every kernel; return the seconds that it took."""
    start = time.perf_counter()
    angles = np.linspace(-math.pi, math.pi, 60, endpoint=False)
    ranges = 2.0 / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
    room = PlanarScan(0.0, angles, ranges, (0.0, 0.0, 0.0), 10.0)
    slam = _two_scans(room)
    hall = _two_scans(PlanarScan(0.0, angles, 15.0 * ranges, (0.0, 0.0, 0.0), 60.0))
    hall.agreement(room, (20.0, 0.0, 0.0))
    hall.grid()
    Link.between(room, room, np.zeros((1, 3)))
    search = PlaceSearch(LikelihoodField.from_grid(slam.grid()))
    search.find(ranges[:, None] * np.column_stack([np.cos(angles), np.sin(angles)]), SearchSettings())
    return time.perf_counter() - start


def _two_scans(scan: PlanarScan) -> GridSlam:
    """Return a filter with two particles, resampled between two scans."""
    slam = GridSlam(SlamParameters(particles=2, temporalUpdate=0.0))
    slam.process(scan, (0.0, 0.0, 0.0))
    slam.relocate((0.0, 0.0, 0.0), 1e-6 * np.eye(3), scan.stamp_s)
    slam.process(dataclasses.replace(scan, stamp_s=scan.stamp_s + 1.0), (0.1, 0.0, 0.0))
    return slam


if __name__ == "__main__":
    # Imported here, because they would slow the node's start
    from gridslam.cloud_odometry.warm_up import warm_up_cloud_odometry
    from gridslam.loop_closure.warm_up import warm_up_loop_closure
    from gridslam.odometry.warm_up import warm_up_odometry
    from gridslam.volume.warm_up import warm_up_volume

    others = warm_up_loop_closure, warm_up_odometry, warm_up_cloud_odometry, warm_up_volume
    seconds = warm_up() + sum(other() for other in others)
    print(f"gridslam's kernels are ready after {seconds:.1f} s.")
