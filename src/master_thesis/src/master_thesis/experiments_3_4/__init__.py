"""Experiments 3 and 4: a flight that maps, and how far the map and the path are from the truth."""
