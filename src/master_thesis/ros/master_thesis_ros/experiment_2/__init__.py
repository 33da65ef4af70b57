"""The driver of Experiment 2."""
