"""Experiments 3 and 4 without GNSS: the flight by the lidar alone, and its section in the report."""
