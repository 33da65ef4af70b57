"""Launches: checks of what is asked for, times of a start, and how a launch ends."""
