"""The energy for the way home: what the battery still has, and when to go back or to land."""

from inspection_tools.energy.charge import Charge
from inspection_tools.energy.decision import Decision, EnergyWatch, Verdict, WayHome
from inspection_tools.energy.pace import Course, Pace
from inspection_tools.energy.parameters import EnergyParameters
from inspection_tools.energy.readings import Readings
from inspection_tools.energy.way_back import WayBack, without_loops

__all__ = [
    "Charge",
    "Course",
    "Decision",
    "EnergyParameters",
    "EnergyWatch",
    "Pace",
    "Readings",
    "Verdict",
    "WayBack",
    "WayHome",
    "without_loops",
]
