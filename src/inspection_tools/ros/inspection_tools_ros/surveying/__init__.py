"""The ROS side of `inspect`: goals, photographs, what it publishes, lockstep."""
