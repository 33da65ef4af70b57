"""The straight leg from one setpoint to the next, and the place on it to fly to (follow the carrot)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

CORNER_M = 1.0
"""If the UAV is farther than this from its last setpoint, its leg begins where it is."""


@dataclass(frozen=True)
class Leg:
    """A horizontal straight line. begin_m, end_m: its ends, (x, y)."""

    begin_m: tuple[float, float]
    end_m: tuple[float, float]

    @classmethod
    def of(cls, last_m: Sequence[float] | None, here_m: Sequence[float], setpoint_m: Sequence[float]) -> Leg:
        """Return the leg from the last setpoint, if there is one and the UAV is near it, else from here."""
        comes_from_there = last_m is not None and math.dist(last_m[:2], here_m[:2]) <= CORNER_M
        begin_m = last_m if last_m is not None and comes_from_there else here_m
        return cls((begin_m[0], begin_m[1]), (setpoint_m[0], setpoint_m[1]))

    def way(self, here_m: Sequence[float], lookahead_m: float) -> tuple[float, float]:
        """Return the way (x, y) from here to the place `lookahead_m` ahead on the leg, or to its end."""
        left_m = self.end_m[0] - here_m[0], self.end_m[1] - here_m[1]
        length_m = math.dist(self.begin_m, self.end_m)
        if length_m == 0.0:
            return left_m
        along = ((self.end_m[0] - self.begin_m[0]) / length_m, (self.end_m[1] - self.begin_m[1]) / length_m)
        beyond_m = max(left_m[0] * along[0] + left_m[1] * along[1] - lookahead_m, 0.0)
        return left_m[0] - beyond_m * along[0], left_m[1] - beyond_m * along[1]
