"""Where a UAV is in space, by its lidar's clouds.

The node `lidar_odometry` uses it in place of `gridslam.odometry` when the lidar has clouds.
"""

from gridslam.cloud_odometry.cloud_odometry import CloudOdometry
from gridslam.cloud_odometry.parameters import CloudOdometryParameters
from gridslam.cloud_odometry.sensed_cloud import SensedCloud

__all__ = ["CloudOdometry", "CloudOdometryParameters", "SensedCloud"]
