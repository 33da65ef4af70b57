"""Checks before the first take-off of a real UAV, on the bench."""
