"""The ROS side: the nodes of the experiments, the doctor, and launches."""
