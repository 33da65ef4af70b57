"""A simulation in time: the loop that paces it, lockstep, performance figures, and Gazebo's services."""
