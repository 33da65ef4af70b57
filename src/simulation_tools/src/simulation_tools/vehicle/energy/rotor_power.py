"""The electric power that rotors draw, by a model that was identified in flight.

Liu, Sengupta and Kurzhanskiy, "A power consumption model for multi-rotor small unmanned aircraft systems"
(ICUAS 2017, table I; flown on an IRIS+). For the thrust T of the whole multirotor and its climb V:

    induced power   k1 T (V/2 + sqrt((V/2)^2 + T / k2^2))
    profile power   c2 T^1.5

In hover this is (k1 / k2 + c2) T^1.5 = 3.12 T^1.5. Their c3 is zero; the drag of the body costs thrust here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flight_basics.checks import check_limits, limited
from kernel_cache.compiler import njit
from simulation_tools.vehicle.energy.battery import BatteryError


@dataclass(frozen=True)
class RotorPower:
    """The model's coefficients for a whole multirotor; the defaults are the paper's, of the IRIS+.

    k1: without unit. k2: sqrt(kg/m). c2: sqrt(m/kg). Smaller rotors: k2 grows with their radius, c2 falls.
    """

    k1: float = limited(0.8554, above=0.0)
    k2: float = limited(0.3051, above=0.0)
    c2: float = limited(0.3177, 0.0)

    def __post_init__(self) -> None:
        check_limits(self, BatteryError, "The rotors' power: rotor_{}")

    def hover_power_w(self, thrust_n: float) -> float:
        """Return the power of all rotors in hover, closed form, W. thrust_n: of all rotors."""
        return (self.k1 / self.k2 + self.c2) * thrust_n**1.5

    def power_w(self, thrusts_n: np.ndarray, climb_m_s: float) -> float:
        """Return the power of rotors with thrusts (n,), each an n-th of the paper's multirotor, W.

        climb_m_s: of the rotors through the air along their axes.
        """
        return float(_power(thrusts_n, climb_m_s, self.k1, self.k2, self.c2))


@njit(cache=True)
def _power(thrusts: np.ndarray, climb: float, k1: float, k2: float, c2: float) -> float:
    """A rotor's T is an n-th of the whole's, so T / k2^2 becomes n T / k2^2, and c2 becomes c2 sqrt(n)."""
    n, half = len(thrusts), 0.5 * climb
    total = 0.0
    for thrust in thrusts:
        if thrust > 0.0:
            total += k1 * thrust * (half + math.sqrt(half * half + n * thrust / (k2 * k2)))
            total += c2 * math.sqrt(n) * thrust * math.sqrt(thrust)
    return total
