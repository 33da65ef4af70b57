"""Photographs on disk, for us and for other tools."""
