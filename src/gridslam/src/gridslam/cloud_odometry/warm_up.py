"""Compiles the kernels of the cloud odometry ahead of the first cloud."""

from __future__ import annotations

import time

import numpy as np

from gridslam.cloud_odometry.cloud_odometry import CloudOdometry
from gridslam.cloud_odometry.parameters import CloudOdometryParameters
from gridslam.cloud_odometry.plane_map import FIRST_SLOTS, PlaneMap


def warm_up_cloud_odometry() -> float:
    """Follow three clouds of a square room; return the seconds that it took."""
    start = time.perf_counter()
    along, up = (each.ravel() for each in np.meshgrid(np.arange(-2.0, 2.0, 0.1), np.arange(-1.0, 1.0, 0.1)))
    away = np.full_like(along, 2.0)
    walls = ((away, along, up), (-away, along, up), (along, away, up), (along, -away, up))
    points = np.concatenate([np.column_stack(wall) for wall in walls]).astype(np.float32)
    odometry = CloudOdometry()
    level = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
    for stamp_s in (0.0, 1.0, 2.0):
        odometry.on_cloud(stamp_s, points, level)
    odometry.planes.slope_at(np.zeros(3), np.zeros(3))  # without a range finder it does not ask for the floor
    PlaneMap(CloudOdometryParameters()).reserve(FIRST_SLOTS)  # only a larger map needs it
    return time.perf_counter() - start
