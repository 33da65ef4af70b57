"""Tells when level scans have come to another height, where they see another slice of the world."""

from __future__ import annotations

import math
from dataclasses import dataclass

BAND_M = 0.5
"""Heights that differ by more are other slices; LoopClosureParameters.height_band_m has the same default."""
WAY_M = 1.0
"""A height counts once the vehicle has flown this far at it. So take-off and landing are no change."""


@dataclass(frozen=True)
class SliceState:
    """A `SliceWatch` to save. bands_m: the heights so far. band_m: the present one of these, or NaN."""

    bands_m: tuple[float, ...]
    band_m: float
    new_m: float
    way_m: float
    place: tuple[float, float] | None


class SliceWatch:
    """Follows the heights at which the vehicle flies.

    Args:
        band_m: heights that differ by more are other slices.
    """

    def __init__(self, band_m: float = BAND_M) -> None:
        self._half_m = band_m
        self._bands_m: list[float] = []
        self._band_m = math.nan  # at which it has flown WAY_M
        self._new_m, self._way_m = math.nan, 0.0
        self._place: tuple[float, float] | None = None

    def is_between(self, height_m: float) -> bool:
        """Return whether this is the height of another slice, at which it has not flown `WAY_M` yet."""
        return abs(height_m - self._band_m) > self._half_m  # NaN is of no other slice

    def follow(self, x_m: float, y_m: float, height_m: float) -> tuple[float, float] | None:
        """Take in the vehicle's place and height in the odometry's frame.

        Returns:
            The heights in m of the slice before and of the one now, if it has changed; else None.
        """
        place, self._place = self._place, (x_m, y_m)
        if not (self.is_between(height_m) or math.isnan(self._band_m)):
            self._new_m, self._way_m = math.nan, 0.0
            return None
        if place is None or not abs(height_m - self._new_m) <= self._half_m:  # also NaN
            self._new_m, self._way_m = height_m, 0.0
            return None
        self._way_m += math.hypot(x_m - place[0], y_m - place[1])
        if self._way_m < WAY_M:
            return None
        before_m, self._band_m = self._band_m, self._known(height_m)
        self._new_m, self._way_m = math.nan, 0.0
        return None if math.isnan(before_m) else (before_m, self._band_m)

    def _known(self, height_m: float) -> float:
        """Return the height of the slice that was seen before at this one, or this one, which is new."""
        near_m = min(self._bands_m, key=lambda band_m: abs(band_m - height_m), default=math.nan)
        if abs(near_m - height_m) <= self._half_m:
            return near_m
        self._bands_m.append(height_m)
        return height_m

    def state(self) -> SliceState:
        """Return all that is known."""
        return SliceState(tuple(self._bands_m), self._band_m, self._new_m, self._way_m, self._place)

    def restore(self, state: SliceState) -> None:
        """Go on from a state."""
        self._bands_m, self._band_m = list(state.bands_m), state.band_m
        self._new_m, self._way_m, self._place = state.new_m, state.way_m, state.place
