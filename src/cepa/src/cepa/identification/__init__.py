"""Finds how a UAV follows velocity commands, from a recording or from a flight of steps."""
