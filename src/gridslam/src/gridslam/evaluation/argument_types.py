"""The numbers that the command's options take."""

from __future__ import annotations

import argparse
import math


def finite(text: str) -> float:
    """Return a finite number."""
    value = _number(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"must be a finite number, not {text}")
    return value


def positive(text: str) -> float:
    """Return a finite number above 0."""
    value = _number(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"must be greater than 0, not {text}")
    return value


def _number(text: str) -> float:
    """Return NaN for what is not a number, so that the bounds refuse it with their own words."""
    try:
        return float(text)
    except ValueError:
        return math.nan
