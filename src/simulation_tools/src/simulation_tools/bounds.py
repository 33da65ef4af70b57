"""Bounds on numbers from outside: what MAVLink's fields can carry, and what makes sense in a world."""

from __future__ import annotations

from typing import Iterable

FLOAT32_MAX = 3.4028234663852886e38
MAX_DISTANCE_M = 1e6
"""No world is larger; squares of much greater numbers leave a float32's range, and rays become noise."""


def fit_float32(values: Iterable[float]) -> bool:
    """Tell whether all of the numbers are finite as float32 too."""
    return all(abs(value) <= FLOAT32_MAX for value in values)
