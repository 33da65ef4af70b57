"""Compares odometry and the lidar's mounting with what the scans tell, and refuses what cannot be right."""
