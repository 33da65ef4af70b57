"""Lidar odometry, a product of its own: where a UAV is, from its lidar, IMU and range finder, without SLAM.

SLAM does not need it, and it does not need SLAM: it takes scans and gives poses in `odom`, with covariances.
Its node is `lidar_odometry`. See doc/lidar_odometry.md.
"""

from gridslam.odometry.lidar_odometry import LidarOdometry, OdometryEstimate
from gridslam.odometry.parameters import LidarOdometryParameters

__all__ = ["LidarOdometry", "LidarOdometryParameters", "OdometryEstimate"]
