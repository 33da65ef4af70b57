"""Rows of `bench volume`."""
