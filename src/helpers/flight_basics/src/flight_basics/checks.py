"""Checks that the parameter classes share; each raises one sentence that names the parameter."""

from __future__ import annotations

from dataclasses import field, fields
from typing import Any

from flight_basics.errors import ParameterError


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


def limited(default: Any, least: float | str, most: float | str) -> Any:
    """Return a field of a dataclass of parameters, whose limits `check_parameters` checks.

    least, most: the value may be as small and as large as this; or names of fields that are the limits. Where
    the default is None, the value may be None, too.
    """
    return field(default=default, metadata={"least": least, "most": most})


def check_parameters(parameters: Any) -> None:
    """Check the fields of a dataclass: each that is `limited`, and each that is a bool.

    Raises:
        ParameterError: the first value that is out of range.
    """
    limits_by_others = []
    for each in fields(parameters):
        value = getattr(parameters, each.name)
        if each.type == "bool":
            check_flag(each.name, value)
        elif each.metadata and not (value is None and each.default is None):
            least, most = each.metadata["least"], each.metadata["most"]
            if isinstance(least, str) or isinstance(most, str):
                limits_by_others.append((each.name, value, least, most))
            else:
                (check_whole if each.type == "int" else check_number)(each.name, value, least, most)
    for name, value, *limits in limits_by_others:  # those are known to be numbers now
        least, most = (getattr(parameters, each) if isinstance(each, str) else each for each in limits)
        check_number(name, value, least, most)
