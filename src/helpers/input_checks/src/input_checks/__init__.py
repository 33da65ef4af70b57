"""Compares the inputs of a node with each other; each check tells one sentence, or what to leave out. It imports no ROS."""
