"""Tracks of obstacles: which things in the scans move, and how fast."""
