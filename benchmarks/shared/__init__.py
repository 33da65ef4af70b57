"""Shared by several benchmarks: results, trials, places, anchors."""
