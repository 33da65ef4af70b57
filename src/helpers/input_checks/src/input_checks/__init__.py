"""Compares the inputs of a node with each other: tells one sentence, or what to leave out. It imports no ROS."""
