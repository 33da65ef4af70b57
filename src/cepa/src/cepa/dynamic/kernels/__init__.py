"""Compiled inner loops: the UAV's response, clearances along its paths, distance fields."""
