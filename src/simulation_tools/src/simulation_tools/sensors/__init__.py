"""Simulated sensors: lidar, inertial measurement unit, drifting odometry."""
