"""The edge to ROS that every node of the workspace shares; it knows no UAV and no message of ours."""
