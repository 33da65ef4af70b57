"""Launches: checks of their arguments, times of a start, and how a launch ends."""
