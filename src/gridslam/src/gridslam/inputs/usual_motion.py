"""Learns how far odometry usually moves from one reading to the next."""

from __future__ import annotations

import math

READINGS_MIN = 10
"""Fewer readings, or less way than the next, tell nothing of what is usual."""
WAY_MIN_M = 1.0
NUMBERS = ("readings", "way_m", "turned_rad", "seconds", "longest_m", "longest_rad", "longest_s")


class UsualMotion:
    """Sums and greatest steps of the readings so far."""

    def __init__(self) -> None:
        self.readings = 0
        self.way_m = self.turned_rad = self.seconds = 0.0
        self.longest_m = self.longest_rad = self.longest_s = 0.0

    @property
    def is_known(self) -> bool:
        """Whether there were enough readings to tell what is usual."""
        return self.readings >= READINGS_MIN and self.way_m >= WAY_MIN_M

    def add(self, seconds: float, way_m: float, turned_rad: float) -> None:
        """Take in one step."""
        self.readings += 1
        self.way_m += way_m
        self.turned_rad += turned_rad
        self.seconds += seconds
        self.longest_m = max(self.longest_m, way_m)
        self.longest_rad = max(self.longest_rad, turned_rad)
        self.longest_s = max(self.longest_s, seconds)

    def most(self, seconds: float) -> tuple[float, float]:
        """Return the greatest way in m and turn in rad that a step of this time had, or would have had."""
        times = max(1.0, seconds / self.longest_s) if self.longest_s else 1.0
        return times * self.longest_m, times * self.longest_rad

    def mean(self, seconds: float) -> tuple[float, float]:
        """Return the mean way in m, and turning in rad, in this time."""
        share = seconds / self.seconds if self.seconds else 0.0
        return share * self.way_m, share * self.turned_rad

    def state(self) -> dict[str, float]:
        """Return the input of `restore`."""
        return {name: getattr(self, name) for name in NUMBERS}

    def restore(self, state: dict[str, float]) -> None:
        """Go on from a state.

        Raises:
            KeyError: something lacks in it.
            ValueError: it makes no sense.
        """
        for name in NUMBERS:
            value = float(state[name])
            if not 0.0 <= value < math.inf:
                raise ValueError("the odometry's usual motion is none")
            setattr(self, name, int(value) if name == "readings" else value)
