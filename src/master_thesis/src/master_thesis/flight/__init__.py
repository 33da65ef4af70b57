"""One flight: its course, its log, and the closed loop that flies it without ROS."""
