"""Compares the inputs of a node with each other; each check tells a sentence, or what to leave out. No ROS."""
