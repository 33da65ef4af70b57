"""What the nodes share: the driver that starts and ends a run, messages, parameters, the watch on SLAM."""
