"""Pairs messages of several topics by their stamps."""
