"""The shared edge to ROS of all nodes. It knows no UAV and none of our messages."""
