"""What happens when the time of a mission is over."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum


class TimeIsOver(Enum):
    """What the caller does then, once."""

    FLY_HOME = "fly back to the start"
    END_HERE = "count the goal as reached"


@dataclass(frozen=True)
class MissionTime:
    """The time that a mission may take. duration_s: infinite: any. returns: fly home then, or end there."""

    duration_s: float
    returns: bool = False

    def over(self, flying_s: float, flies_home: bool) -> TimeIsOver | None:
        """Return what to do after so many seconds of flight; None: fly on."""
        if flies_home or flying_s < self.duration_s:
            return None
        return TimeIsOver.FLY_HOME if self.returns else TimeIsOver.END_HERE

    def left_in_words(self, flying_s: float, flies_home: bool) -> str:
        """Return when the time will be over, as the end of a sentence; empty: nothing ends the flight."""
        left_s = self.duration_s - flying_s
        if flies_home or not math.isfinite(left_s):
            return ""
        return f"; its time is over in {max(left_s, 0.0):.0f} s"
