"""Rows of `bench inspection`."""
