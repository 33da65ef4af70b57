"""Simulated sensors: lidar, IMU, drifting odometry, cameras and others, and when they fire."""
