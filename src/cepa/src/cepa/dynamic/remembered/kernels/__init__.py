"""Compiled inner loops: cells of remembered points, and beams that stand out alone."""
