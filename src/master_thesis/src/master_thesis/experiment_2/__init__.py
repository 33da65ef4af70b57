"""Experiment 2: an emergency frozen in the air, what both algorithms propose, and what comes of it."""
