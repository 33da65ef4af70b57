"""Compiled inner loops of the thesis's algorithms, on plain arrays.

Conventions: ``ranges`` are float64 metres on a full turn of beams, +inf where nothing is seen; directions are
unit vectors in the grid's own frame (beam 0 along x).
"""
