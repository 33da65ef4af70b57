"""Compiles the kernels of the lidar odometry ahead of the first scan."""

from __future__ import annotations

import math
import time

import numpy as np

from gridslam.kernels.surfels import SurfelTable, move_cells
from gridslam.odometry.lidar_odometry import LidarOdometry


def warm_up_odometry() -> float:
    """Follow three scans of a square room; return the seconds that it took."""
    start = time.perf_counter()
    angles = np.linspace(-math.pi, math.pi, 120, endpoint=False)
    ranges = 2.0 / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
    odometry = LidarOdometry()
    level = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
    for stamp_s in (0.0, 1.0, 2.0):
        odometry.on_scan(stamp_s, ranges, (-math.pi, math.tau / 120), (0.1, 10.0), level)
    move_cells(SurfelTable.empty(2), SurfelTable.empty(2))  # only a larger map needs it
    return time.perf_counter() - start
