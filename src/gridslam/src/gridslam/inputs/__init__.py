"""Turns the scans of any lidar and the odometry of any vehicle into what the filter takes."""
