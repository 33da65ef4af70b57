"""Experiments 3 and 4: a flight with SLAM, and how far its map and path are from the truth."""
