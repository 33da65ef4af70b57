"""Experiment 2: obstacles appear around a hovering UAV. It records both proposals and the flight."""
