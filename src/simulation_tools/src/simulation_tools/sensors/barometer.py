"""A barometer in the International Standard Atmosphere."""

from __future__ import annotations

import numpy as np

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import AirPressureSensor

SEA_LEVEL_PA = 101325.0
SEA_LEVEL_K = 288.15
LAPSE_K_PER_M = 0.0065
EXPONENT = 9.80665 * 0.0289644 / (8.31432 * LAPSE_K_PER_M)
"""g M / (R L) with the R of the U.S. Standard Atmosphere 1976: 5.2559."""


class Barometer:
    """One barometer. stddev_pa: of its noise."""

    def __init__(self, sensor: AirPressureSensor, rng: np.random.Generator) -> None:
        """Set it up. rng: source of the noise."""
        self.stddev_pa = sensor.noise.stddev
        self._mean_pa = sensor.noise.mean
        self._reference_altitude_m = sensor.reference_altitude_m
        self._rng = rng

    def read(self, pose: Pose) -> float:
        """Return the pressure in Pa. pose: in the world, whose origin is at the reference altitude."""
        noise = self._mean_pa + self.stddev_pa * float(self._rng.standard_normal())
        return pressure_pa(self._reference_altitude_m + pose.position_m[2]) + noise


def pressure_pa(altitude_m: float) -> float:
    """Return the standard atmosphere's pressure in its lowest layer, which ends at 11 km."""
    warmth = 1.0 - LAPSE_K_PER_M * altitude_m / SEA_LEVEL_K
    return SEA_LEVEL_PA * max(warmth, 0.0) ** EXPONENT
