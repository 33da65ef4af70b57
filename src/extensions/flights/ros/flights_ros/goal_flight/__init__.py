"""The driver of Experiment 1."""
