"""Experiment 1: flights to a goal among obstacles."""
