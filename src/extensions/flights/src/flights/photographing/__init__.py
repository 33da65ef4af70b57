"""Photographs of a simulated world, from a list of poses."""
