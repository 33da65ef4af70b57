"""Learns how far odometry usually moves from one reading to the next."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

READINGS_MIN = 10
"""Fewer readings, or less way than the next, tell nothing of what is usual."""
WAY_MIN_M = 1.0


@dataclass(frozen=True)
class UsualMotionState:
    """`UsualMotion` to save. The fields are its attributes.

    Raises:
        ValueError: they make no sense.
    """

    readings: int
    way_m: float
    turned_rad: float
    seconds: float
    longest_m: float
    longest_rad: float
    longest_s: float
    fastest_mps: float
    fastest_radps: float

    def __post_init__(self) -> None:
        if not all(0.0 <= getattr(self, field.name) < math.inf for field in fields(self)):
            raise ValueError("the odometry's usual motion is none")


class UsualMotion:
    """Sums and greatest steps of the readings so far."""

    def __init__(self) -> None:
        self.readings = 0
        self.way_m = self.turned_rad = self.seconds = 0.0
        self.longest_m = self.longest_rad = self.longest_s = 0.0
        self.fastest_mps = self.fastest_radps = 0.0
        """Greatest speeds of steps that are no shorter than the mean one: a shorter one exaggerates noise."""

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
        if seconds > 0.0 and seconds >= self.seconds / self.readings:
            self.fastest_mps = max(self.fastest_mps, way_m / seconds)
            self.fastest_radps = max(self.fastest_radps, turned_rad / seconds)

    def most(self, seconds: float) -> tuple[float, float]:
        """Return the greatest way in m and turn in rad that a step of this time had, or would have had.

        A long step tells little of the speed, as after a pause without readings. So the fastest step counts.
        """
        times = max(1.0, seconds / self.longest_s) if self.longest_s else 1.0
        return (
            max(times * self.longest_m, seconds * self.fastest_mps),
            max(times * self.longest_rad, seconds * self.fastest_radps),
        )

    def mean(self, seconds: float) -> tuple[float, float]:
        """Return the mean way in m, and turning in rad, in this time."""
        share = seconds / self.seconds if self.seconds else 0.0
        return share * self.way_m, share * self.turned_rad

    def state(self) -> UsualMotionState:
        """Return the sums and greatest steps."""
        return UsualMotionState(*(getattr(self, field.name) for field in fields(UsualMotionState)))

    def restore(self, state: UsualMotionState) -> None:
        """Go on from a state."""
        for field in fields(UsualMotionState):
            setattr(self, field.name, getattr(state, field.name))
