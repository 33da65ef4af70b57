"""Points of sensor_msgs/PointCloud2 for CEPA."""

from __future__ import annotations

import numpy as np
from sensor_msgs.msg import PointCloud2

from cepa import MotionError
from input_checks_ros.lidar_readings import LidarReadings
from node_tools import clouds


def points_of(message: PointCloud2, readings: LidarReadings) -> np.ndarray:
    """Return the points (n, 3) of a cloud in its own frame, m; rows are NaN where a beam met nothing.

    Raises:
        MotionError: the cloud cannot be read, or has no valid point at all.
    """
    try:
        points_m = clouds.points_of(message)
    except clouds.CloudError as error:
        raise MotionError(str(error)) from None
    if not np.isfinite(points_m).all(axis=1).any():
        raise MotionError(f"The cloud has no valid point among {len(points_m)}; is its sensor covered?")
    return readings.met(message.header, points_m).astype(float)
