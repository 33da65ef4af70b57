"""One flight: its course from start to landing, its log, and the closed loop that flies it without ROS."""
