"""Compiled inner loops: clusters of a scan's points, their sides, tracks, drift and evidence."""
