"""Exploration in the closed loop without ROS: odometry by clouds, the map of voxels, planner and explorer."""
