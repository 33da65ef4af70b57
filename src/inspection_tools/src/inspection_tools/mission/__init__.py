"""Waypoints that are flown one after the other, and their file."""
