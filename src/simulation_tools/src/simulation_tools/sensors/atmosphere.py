"""The standard atmosphere up to 11 km (ISO 2533: sea level 15 degrees Celsius and 1013.25 hPa, 6.5 K/km)."""

from __future__ import annotations

SEA_LEVEL_PA = 101325.0
SEA_LEVEL_K = 288.15
LAPSE_K_PER_M = 0.0065
_EXPONENT = 9.80665 * 0.0289644 / (8.31446 * LAPSE_K_PER_M)  # g M / (R L)


def temperature_k(altitude_m: float) -> float:
    """Return the temperature of the air, K, at an altitude above mean sea level."""
    return SEA_LEVEL_K - LAPSE_K_PER_M * altitude_m


def pressure_pa(altitude_m: float) -> float:
    """Return the pressure of the air, Pa, at an altitude above mean sea level."""
    return SEA_LEVEL_PA * (temperature_k(altitude_m) / SEA_LEVEL_K) ** _EXPONENT
