"""Checks before anything flies: the values of a launch file's arguments, and of a driver's parameters."""
