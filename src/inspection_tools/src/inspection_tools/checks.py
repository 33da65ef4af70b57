"""Checks that the parameter classes share; each raises one sentence that names the parameter."""

from __future__ import annotations

from typing import Any

from inspection_tools.errors import ParameterError


def check_whole(name: str, value: Any, low: int, high: int) -> None:
    """Raise ParameterError unless `value` is a whole number from `low` to `high`."""
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise ParameterError(f"{name} is {value!r}; it must be a whole number from {low} to {high}.")


def check_flag(name: str, value: Any) -> None:
    """Raise ParameterError unless `value` is True or False; the text "false" would count as true."""
    if not isinstance(value, bool):
        raise ParameterError(f"{name} is {value!r}; it must be true or false.")


def check_number(name: str, value: Any, low: float, high: float) -> None:
    """Raise ParameterError unless `value` is a finite number from `low` to `high`."""
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not is_number or not low <= value <= high:  # NaN fails this test too
        raise ParameterError(f"{name} is {value!r}; it must be a number from {low:g} to {high:g}.")
