"""Simulation description files (SDF 1.6): read, checked, and turned into plain dataclasses."""
