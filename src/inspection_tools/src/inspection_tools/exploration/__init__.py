"""Where a UAV flies next to know all of a place, and when nothing is left; needs numba.

The map and the ways are those of `planning`.
"""

from inspection_tools.exploration.exploration import Exploration
from inspection_tools.exploration.explorer import Decision, Explorer
from inspection_tools.exploration.parameters import ExplorationParameters, ExplorerParameters
from inspection_tools.exploration.told import End, Explored
from inspection_tools.exploration.unknown.leftovers import Leftover, Why

__all__ = [
    "Decision",
    "End",
    "Exploration",
    "ExplorationParameters",
    "Explored",
    "Explorer",
    "ExplorerParameters",
    "Leftover",
    "Why",
]
