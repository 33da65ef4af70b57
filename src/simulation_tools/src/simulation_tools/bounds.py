"""Bounds on numbers from outside: the range of MAVLink's fields, and what is possible in a world."""

from __future__ import annotations

from typing import Iterable

FLOAT32_MAX = 3.4028234663852886e38
MAX_MAGNITUDE = 1e6
"""The greatest length (m) or speed (m/s, rad/s) in a world. Squares of much greater numbers overflow."""


def are_sane(values: Iterable[float]) -> bool:
    """Return whether all numbers can be lengths or speeds in a world; NaN and infinity cannot."""
    return all(abs(value) <= MAX_MAGNITUDE for value in values)


def fit_float32(values: Iterable[float]) -> bool:
    """Return whether all numbers are finite as float32."""
    return all(abs(value) <= FLOAT32_MAX for value in values)
