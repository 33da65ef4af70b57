"""The ROS side: the nodes that control a flight, and launches."""
