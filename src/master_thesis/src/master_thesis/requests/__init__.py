"""Checks before anything flies: the parameters of a driver and the arguments of a launch file."""
