"""Checks that the parameter classes share; each raises one sentence that names the parameter."""

from __future__ import annotations

import math
import numbers
import sys
from dataclasses import Field, field, fields
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
    """Raise ParameterError unless `value` is a number from `low` to `high`, which a float can hold."""
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not is_number or not low <= value <= high or sys.float_info.max < abs(value) < math.inf:  # or NaN
        raise ParameterError(f"{name} is {value!r}; it must be a number from {low:g} to {high:g}.")


def limited(
    default: Any,
    least: float | str | None = None,
    most: float | str | None = None,
    *,
    above: float | None = None,
    below: float | None = None,
    live: tuple[float, float] | None = None,
    named: str = "",
) -> Any:
    """Return a field of a dataclass of parameters, whose limits are checked when an object is made.

    Where the default is None, the value may be None, too.

    Args:
        default: the value unless told otherwise; `dataclasses.MISSING`: it must be given.
        least: the value may be as small as this; or the name of the field that is the limit.
        most: the value may be as large as this; or the name of the field that is the limit.
        above: the value must be greater than this.
        below: the value must be less than this.
        live: least and greatest value in the .cfg file, which needs both, also where the parameter itself has
            no limit. None: least and most.
        named: what sentences call it; empty: the field's name.
    """
    limits = {"least": least, "most": most, "above": above, "below": below, "live": live, "named": named}
    return field(default=default, metadata=limits)


def check_parameters(parameters: Any) -> None:
    """Check the fields of a dataclass: each that is `limited`, and each that is a bool.

    Raises:
        ParameterError: the first value that is out of range.
    """
    limits_by_others = []
    for each in _to_check(parameters):
        value, name = getattr(parameters, each.name), _name_of(each)
        if each.type == "bool":
            check_flag(name, value)
        elif not (value is None and each.default is None):
            least, most = each.metadata["least"], each.metadata["most"]
            if isinstance(least, str) or isinstance(most, str):
                limits_by_others.append((name, value, least, most))
            elif least is None or most is None:
                must_be = _demand(each, value)
                if must_be:
                    raise ParameterError(f"{name} is {value!r}; it must be {must_be}.")
            else:
                (check_whole if each.type == "int" else check_number)(name, value, least, most)
    for name, value, *limits in limits_by_others:  # those are known to be numbers now
        least, most = (getattr(parameters, each) if isinstance(each, str) else each for each in limits)
        check_number(name, value, least, most)


def check_limits(parameters: Any, error: type[Exception], called: str = "{}") -> None:
    """Check the fields of a dataclass: each that is `limited`, and each that is a bool.

    The sentence tells the one limit that a value does not keep, because here many limits have one side only.

    Args:
        parameters: an object of the dataclass.
        error: what is raised: each package has its own.
        called: what the sentence calls a field, with {} for its name.

    Raises:
        error: the first value that is out of range, or not a finite number. inf may be `most`.
    """
    for each in _to_check(parameters):
        value = getattr(parameters, each.name)
        must_be = "" if value is None and each.default is None else _demand(each, value)
        if must_be:
            raise error(f"{called.replace('{}', _name_of(each))} must be {must_be}, not {value!r}.")


def _to_check(parameters: Any) -> list[Field[Any]]:
    return [each for each in fields(parameters) if each.metadata or each.type == "bool"]


def _name_of(each: Field[Any]) -> str:
    """Return what sentences call a field."""
    return each.metadata.get("named") or each.name


def _demand(each: Field[Any], value: Any) -> str:
    """Return what a field's value must be and is not; empty: nothing."""
    if each.type == "bool":
        return "" if isinstance(value, bool) else "true or false"
    least, most, above, below = (each.metadata[name] for name in ("least", "most", "above", "below"))
    is_number = isinstance(value, numbers.Real) and not isinstance(value, bool)
    if not is_number or not (abs(value) <= sys.float_info.max or abs(value) == most):  # NaN fails both
        return "a finite number"
    if each.type == "int" and value != int(value):
        return "a whole number"
    if each.type != "int" and least is not None and most is not None:
        return "" if least <= value <= most else f"between {least:g} and {most:g}"
    if least is not None and value < least:
        return f"at least {least:g}"
    if above is not None and value <= above:
        return f"greater than {above:g}"
    if most is not None and value > most:
        return f"at most {most:g}"
    return f"less than {below:g}" if below is not None and value >= below else ""
