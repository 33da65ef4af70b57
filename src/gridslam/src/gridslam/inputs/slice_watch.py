"""Tells when a planar lidar has come to another height, where it sees another slice of the world."""

from __future__ import annotations

import math
from typing import Callable

BAND_M = 0.5
"""Heights that differ by more are other slices; LoopClosureParameters.height_band_m has the same default."""
WAY_M = 1.0
"""A height counts once the vehicle has flown this far at it. So take-off and landing are not told."""


class SliceWatch:
    """Follows the heights at which the vehicle flies.

    Args:
        say: is called with a sentence.
    """

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._band_m: float | None = None  # at which it has flown WAY_M
        self._new_m, self._way_m = math.nan, 0.0
        self._place: tuple[float, float] | None = None

    def follow(self, x_m: float, y_m: float, height_m: float) -> None:
        """Take in the vehicle's place and height in the odometry's frame."""
        place, self._place = self._place, (x_m, y_m)
        if self._band_m is not None and abs(height_m - self._band_m) <= BAND_M:
            self._new_m, self._way_m = math.nan, 0.0
            return
        if place is None or not abs(height_m - self._new_m) <= BAND_M:  # also NaN
            self._new_m, self._way_m = height_m, 0.0
            return
        self._way_m += math.hypot(x_m - place[0], y_m - place[1])
        if self._way_m < WAY_M:
            return
        if self._band_m is not None:
            self._say(
                f"The vehicle flies at {height_m:.1f} m, and the map is of {self._band_m:.1f} m. A planar "
                "lidar sees another slice there, so the map may be wrong; no loops are closed between both."
            )
        self._band_m, self._new_m, self._way_m = height_m, math.nan, 0.0
