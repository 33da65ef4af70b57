"""Where a UAV is in space, by its lidar's clouds."""

from gridslam.cloud_odometry.cloud_odometry import CloudOdometry
from gridslam.cloud_odometry.parameters import CloudOdometryParameters

__all__ = ["CloudOdometry", "CloudOdometryParameters"]
