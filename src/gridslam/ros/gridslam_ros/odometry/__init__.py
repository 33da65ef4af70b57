"""The lidar odometry and its ROS messages."""
