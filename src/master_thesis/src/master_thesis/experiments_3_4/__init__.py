"""Experiments 3 and 4: a flight with SLAM, and the errors of its map and path."""
