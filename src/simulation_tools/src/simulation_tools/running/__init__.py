"""A simulation in time: the loop that paces it, lockstep's barrier, performance, Gazebo's services."""
