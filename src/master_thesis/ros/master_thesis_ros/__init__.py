"""The ROS side: the nodes of Experiments 2 to 4, and the checks of launches."""
