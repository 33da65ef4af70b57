"""Arc tangents by a polynomial, in a third of the time."""

from __future__ import annotations

import math

from kernel_cache.compiler import njit

ANGLE_ERROR_RAD = 3e-4
"""Of the polynomial."""
LEAST_M = 1e-300
"""The least distance whose direction is known."""


@njit(cache=True, inline="always")
def angle_of(x: float, y: float) -> float:
    """Return atan2(y, x) within ANGLE_ERROR_RAD, in a third of the time, and without a branch."""
    across, along = abs(y), abs(x)
    a = min(across, along) / max(across, along, LEAST_M)
    a2 = a * a
    angle = a * (1.0 + a2 * (-0.327622764 + a2 * (0.15931422 - 0.0464964749 * a2)))
    angle = 0.5 * math.pi - angle if across > along else angle
    angle = math.pi - angle if x < 0.0 else angle
    return -angle if y < 0.0 else angle


@njit(cache=True, inline="always")
def bin_of(ahead: float, left: float, per_rad: float) -> int:
    """Return floor(atan2(left, ahead) * per_rad + 0.5); only near its steps it takes an arc tangent."""
    across, along = abs(left), abs(ahead)
    low, high = (across, along) if across < along else (along, across)
    a = low / high if high > 0.0 else 0.0
    a2 = a * a
    angle = a * (1.0 + a2 * (-0.327622764 + a2 * (0.15931422 - 0.0464964749 * a2)))
    if across > along:
        angle = 0.5 * math.pi - angle
    if ahead < 0.0:
        angle = math.pi - angle
    place = (-angle if left < 0.0 else angle) * per_rad + 0.5
    step = math.floor(place)
    if min(place - step, step + 1.0 - place) > ANGLE_ERROR_RAD * per_rad:
        return step
    return math.floor(math.atan2(left, ahead) * per_rad + 0.5)


@njit(cache=True, inline="always")
def column_of(x: float, y: float, per_rad: float, bins: int) -> int:
    """Return int((atan2(y, x) + pi) * per_rad) % bins; only near its steps it takes an arc tangent."""
    across, along = abs(y), abs(x)
    low, high = (across, along) if across < along else (along, across)
    a = low / high if high > 0.0 else 0.0
    a2 = a * a
    angle = a * (1.0 + a2 * (-0.327622764 + a2 * (0.15931422 - 0.0464964749 * a2)))
    if across > along:
        angle = 0.5 * math.pi - angle
    if x < 0.0:
        angle = math.pi - angle
    place = ((-angle if y < 0.0 else angle) + math.pi) * per_rad
    step = int(place)
    if min(place - step, step + 1.0 - place) > ANGLE_ERROR_RAD * per_rad:
        return step
    return int((math.atan2(y, x) + math.pi) * per_rad) % bins
