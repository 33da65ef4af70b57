"""Checks that a launch makes before anything starts: its files and its ports."""
