"""A simulation that runs in time: the loop that paces it, lockstep, performance, Gazebo's services."""
