"""Logs how far a flight is, and the work after it."""

from __future__ import annotations

import math
import time
from typing import Callable

import rospy

PERIOD_S = 5.0
"""Wall time, because simulated time passes slowly after the flight."""
FLIGHT_PERIOD_S = 30.0
"""Wall time: on a busy machine a flight takes many times its simulated time, and must not seem to hang."""


class Pace:
    """Says when the next line is due, in wall time. The first one is due at once, or after a period.

    Args:
        period_s: between two lines. at_once: see above. clock: wall time, s.
    """

    def __init__(
        self, period_s: float, at_once: bool = True, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._period_s, self._clock = period_s, clock
        self._due_s = -math.inf if at_once else clock() + period_s

    def is_due(self) -> bool:
        """Return whether a line is due. Then the next one is due after a period."""
        now_s = self._clock()
        if now_s < self._due_s:
            return False
        self._due_s = now_s + self._period_s
        return True


class ProgressLog:
    """Logs at how many poses the clearance is measured."""

    def __init__(self) -> None:
        self._pace = Pace(PERIOD_S)

    def __call__(self, done: int, of: int) -> None:
        """Log, if the last time was a while ago."""
        if self._pace.is_due():
            rospy.loginfo(f"Measuring the clearance: {done} of {of}.")


class FlightProgress:
    """Logs how far a flight is, once in a while."""

    def __init__(self, pace: Pace | None = None) -> None:
        self._pace = pace or Pace(FLIGHT_PERIOD_S, at_once=False)

    def tell(self, phase: str, *words: str, home_way_m: float = math.nan, charge: float = math.nan) -> None:
        """Log, if the last time was a while ago. What is not known (NaN) is left out.

        phase, words: what the UAV does, and how far it is. home_way_m: to its home. charge: 0 to 1.
        """
        if self._pace.is_due():
            rospy.loginfo("%s", in_words(phase, *words, home_way_m=home_way_m, charge=charge))


def in_words(phase: str, *words: str, home_way_m: float = math.nan, charge: float = math.nan) -> str:
    """Return one line, for example "Exploring: 40 m3 known, 3 m from home, battery 97 %."."""
    told = list(words)
    if math.isfinite(home_way_m):
        told.append(f"{home_way_m:.0f} m from home")
    if math.isfinite(charge):
        told.append(f"battery {100.0 * charge:.0f} %")
    return (
        f"{phase[:1].upper()}{phase[1:]}: {', '.join(told)}." if told else f"{phase[:1].upper()}{phase[1:]}."
    )
