"""Launches: checks of the arguments of this package's launch files."""
