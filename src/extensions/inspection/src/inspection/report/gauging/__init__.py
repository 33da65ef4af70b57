"""Thickness: the spots that are proposed, and the readings that were taken."""
