"""Scans of a planar lidar that moves, as clouds for the map."""
