"""Turns the scans of any lidar and the odometry of any vehicle into the filter's input."""
