"""Odometry of a UAV from its lidar, IMU and range finder: no wheels, no satellites."""

from gridslam.odometry.lidar_odometry import LidarOdometry, OdometryEstimate
from gridslam.odometry.parameters import LidarOdometryParameters

__all__ = ["LidarOdometry", "LidarOdometryParameters", "OdometryEstimate"]
