"""Where a UAV flies next to know all of a place, and when nothing is left; needs numba.

The map and the ways are those of `planning`.
"""

from exploration.next_view.exploration import Exploration
from exploration.next_view.explorer import Decision, Explorer
from exploration.next_view.outcome import End, Explored
from exploration.next_view.parameters import ExplorationParameters, ExplorerParameters
from exploration.next_view.unknown.leftovers import Leftover, Why

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
