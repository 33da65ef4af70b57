"""The energy for the way home: what the battery still has, and when to go back or to land."""

from exploration.energy.charge import Charge
from exploration.energy.decision import Decision, EnergyWatch, Verdict, WayHome
from exploration.energy.pace import Course, Pace
from exploration.energy.parameters import EnergyParameters
from exploration.energy.readings import Readings
from exploration.energy.way_back import WayBack, without_loops

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
