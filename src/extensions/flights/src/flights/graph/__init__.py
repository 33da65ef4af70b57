"""A graph of ROS nodes that a program starts and watches."""
