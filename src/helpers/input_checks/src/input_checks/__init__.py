"""Compares the inputs of a node with each other. A check tells one sentence, or what to leave out; no ROS."""
