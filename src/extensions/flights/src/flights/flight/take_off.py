"""How high a UAV hovers after a take-off."""

from __future__ import annotations

from flights.errors import FlightError

USUAL_HOVER_M, LEAST_HOVER_M = 2.0, 0.3
"""Over the ground. `hover_height` of mavros_publisher allows no less."""
SPARE_M = 0.2
"""Under a ceiling a UAV hovers so much below the highest place where it may be, if there is room."""


def first_hover_m(highest_m: float, keep_m: float) -> float | None:
    """Return the height over the ground to take off to, where nobody says it; None: nothing fits.

    It is the usual one, or what the room above allows: somewhat below the highest place, but in a low room
    not below the middle.

    Args:
        highest_m: height over the ground up to which the UAV's origin may rise.
        keep_m: that it keeps from all surfaces.
    """
    least_m = max(keep_m, LEAST_HOVER_M)
    if highest_m < least_m - 1e-6:
        return None
    middle_m = (least_m + highest_m) / 2.0
    return round(min(USUAL_HOVER_M, max(highest_m - SPARE_M, middle_m)), 2)


def hover_height_m(room_above_m: float, hover_m: float, ground_clearance_m: float) -> float:
    """Return the height over the ground to rise to: the usual one, or what the room above the UAV allows.

    Args:
        room_above_m: so far the UAV may rise.
        hover_m: its usual height over the ground.
        ground_clearance_m: height of its origin while it stands.

    Raises:
        FlightError: there is too little room. The UAV stays on the ground.
    """
    height_m = min(hover_m, room_above_m + ground_clearance_m)
    if height_m < LEAST_HOVER_M:
        raise FlightError(
            f"The UAV landed below something: it could hover only {height_m:.2f} m over the ground, but "
            f"needs {LEAST_HOVER_M:g} m. It stays on the ground."
        )
    return height_m
