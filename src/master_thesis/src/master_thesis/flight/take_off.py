"""How high a UAV hovers after a take-off between two parts of its errand."""

from __future__ import annotations

from master_thesis.errors import FlightError

LEAST_HOVER_M = 0.5
"""As `hover_height` of mavros_publisher allows."""


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
