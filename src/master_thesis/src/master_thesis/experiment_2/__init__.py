"""Experiment 2: obstacles appear around a hovering UAV; what both algorithms propose, and what happens."""
