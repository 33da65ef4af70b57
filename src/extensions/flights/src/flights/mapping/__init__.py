"""A mission that is flown while SLAM maps, without ROS: its scenarios, SLAM's run, and its errors."""
