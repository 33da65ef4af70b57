"""The flight past a photograph's place: where the UAV aims, so that it does not stop there."""

from __future__ import annotations

import math

import numpy as np

from inspection.flight.motion import Motion

AHEAD_S = 0.6
"""The UAV aims so far beyond the place as it flies in this time. Its approach slows in proportion to the way
that is left (2 1/s, inspecting_controller.yaml), so it has its passing speed at the place."""
SHORT_M = 0.01
"""A shorter leg of a way has no direction."""
TURN_PER_M = math.radians(40.0)
"""For each metre to the place its front may still have to turn so much. Else the UAV slows down."""


def overshoot(places_m: np.ndarray, speed_m_s: float) -> np.ndarray | None:
    """Return the place (x, y, z) straight ahead of a way (n, 3)'s end; None: the way has no direction."""
    last_m = places_m[-1]
    for place_m in places_m[-2::-1]:
        leg_m = last_m - place_m
        length_m = float(np.linalg.norm(leg_m))
        if length_m > SHORT_M:
            return last_m + AHEAD_S * speed_m_s / length_m * leg_m
    return None


class Passing:
    """Tells whether a UAV may fly past a place without slowing down.

    place_m, overshoot_m: (x, y, z) of the photograph, and of where the UAV aims behind it. yaw_rad: of the
    photograph. near_m, turned_rad: so near to place and yaw the photograph is taken.
    """

    def __init__(
        self, place_m: np.ndarray, overshoot_m: np.ndarray, yaw_rad: float, near_m: float, turned_rad: float
    ) -> None:
        self._place_m, self._yaw_rad = place_m, yaw_rad
        self._near_m, self._turned_rad = near_m, turned_rad
        self.overshoot_m = overshoot_m
        self._ahead = (overshoot_m - place_m) / np.linalg.norm(overshoot_m - place_m)

    def goes_on(self, motion: Motion) -> bool:
        """Whether the UAV aims behind the place: its front points there in time, and it is not past it."""
        left_m = float(self._ahead @ (self._place_m - motion.place_m))
        turn = abs(math.remainder(motion.yaw_rad - self._yaw_rad, 2.0 * math.pi))
        return left_m >= -self._near_m and turn <= self._turned_rad + TURN_PER_M * max(left_m, 0.0)
