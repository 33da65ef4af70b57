"""The energy for the way home: what the battery still has, and when to go back or to land."""

from inspection_tools.energy.charge import Charge
from inspection_tools.energy.decision import Decision, EnergyWatch, Verdict, WayHome
from inspection_tools.energy.parameters import EnergyParameters

__all__ = ["Charge", "Decision", "EnergyParameters", "EnergyWatch", "Verdict", "WayHome"]
