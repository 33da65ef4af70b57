"""Finds the vehicle on the map when it is lost."""
