"""Measurements 1 and 2: times to build, launch and shut down, and their sections in the report."""
