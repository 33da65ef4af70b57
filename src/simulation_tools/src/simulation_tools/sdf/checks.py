"""Conditions on numbers, with their words for error messages."""

from __future__ import annotations

import math
from typing import Callable

from simulation_tools.bounds import MAX_MAGNITUDE


class Check:
    """A condition on a number, with its words for error messages."""

    def __init__(self, wanted: str, holds: Callable[[float], bool]) -> None:
        self.wanted = wanted
        self.holds = holds


LENGTH = Check(f"positive and at most {MAX_MAGNITUDE:g} m", lambda value: 0.0 < value <= MAX_MAGNITUDE)
POSITIVE = Check("positive", lambda value: value > 0.0)
NOT_NEGATIVE = Check("zero or positive", lambda value: value >= 0.0)


def whole_number(low: int, high: int) -> Check:
    """Check for a whole number in a closed interval."""
    return Check(f"a whole number from {low} to {high}", lambda v: v == math.floor(v) and low <= v <= high)
