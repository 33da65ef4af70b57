"""Listens to the graph on the bench, before the first take-off of a real UAV."""
