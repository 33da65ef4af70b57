"""Between the library and ROS: the nodes of the experiments, the doctor, and launches."""
