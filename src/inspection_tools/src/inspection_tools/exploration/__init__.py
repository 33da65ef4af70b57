"""Where a UAV flies next to know all of a place, and when nothing is left; needs numba.

The map and the ways are those of `planning`.
"""

from inspection_tools.exploration.explorer import Decision, Explorer, Leftover, Why
from inspection_tools.exploration.parameters import ExplorerParameters

__all__ = ["Decision", "Explorer", "ExplorerParameters", "Leftover", "Why"]
