"""Private ROS parameters as typed, checked objects, and dynamic_reconfigure of them."""

from __future__ import annotations

import dataclasses
import re
from typing import Any, Callable, Mapping, TypeVar

import rospy

Parameters = TypeVar("Parameters", bound=Any)
"""A dataclass that checks itself."""
_EXPONENT = re.compile(r"([-+]?)(\d+)(?:\.(\d*))?[eE]([-+]?)(\d+)")


def exponents_as_text(values: Mapping[str, Any]) -> str:
    """Return a sentence about values like 1e9, which YAML reads as text; empty if there are none."""
    for name, value in values.items():
        number = _EXPONENT.fullmatch(value) if isinstance(value, str) else None
        if number:
            sign, whole, rest, power_sign, power = number.groups()
            meant = f"{sign}{whole}.{rest or 0}e{power_sign or '+'}{power}"
            return f"YAML reads {value} as text: write {name}: {meant}, with a point and a sign."
    return ""


def read_values(defaults: Mapping[str, Any]) -> dict[str, Any]:
    """Return the private parameters of these names, or their defaults.

    YAML does not know the wanted type. So if the default is a float, a whole number becomes a float. If the
    default is a str, a number becomes a str. A name may lead into a namespace: "sensor_model/hit". One call
    asks the parameter server for all of them.
    """
    given = _given()
    return {name: _like(default, _in(given, name, default)) for name, default in defaults.items()}


def write_values(values: Mapping[str, Any]) -> None:
    """Set the private parameters, in one call. dynamic_reconfigure reads them without converting types."""
    rospy.set_param("~", {**_given(), **values})


def read_parameters(parameter_class: type[Parameters]) -> Parameters:
    """Return `parameter_class`, a dataclass that checks itself, filled from the private parameters.

    Raises:
        what `parameter_class` raises for a wrong parameter.
    """
    values = read_values({field.name: field.default for field in dataclasses.fields(parameter_class)})
    parameters = parameter_class(**values)
    write_values(values)
    return parameters


def serve_parameters(
    config_type: Any, parameters: Parameters, apply: Callable[[Parameters], None], errors: type[Exception]
) -> Any:
    """Offer `parameters`, a dataclass that checks itself, in dynamic_reconfigure; see `serve`."""
    parameter_class = type(parameters)
    names = [field.name for field in dataclasses.fields(parameter_class)]
    return serve(
        config_type,
        parameters,
        lambda config: parameter_class(**{name: config[name] for name in names}),
        lambda given: dataclasses.asdict(given),
        apply,
        errors,
    )


def serve(
    config_type: Any,
    parameters: Parameters,
    read: Callable[[Mapping[str, Any]], Parameters],
    write: Callable[[Parameters], Mapping[str, Any]],
    apply: Callable[[Parameters], None],
    errors: type[Exception],
) -> Any:
    """Return a dynamic_reconfigure server. It refuses a bad set of parameters and keeps the last one.

    Args:
        config_type: module generated from a .cfg file.
        parameters: the present set.
        read: turns a configuration into a set, or raises one of `errors`.
        write: turns a set into a configuration.
        apply: is called with each new set.
        errors: base class of the errors of `read`.
    """
    from node_tools.tuning_server import TuningServer  # slow to import

    accepted = dict(write(parameters))

    def on_change(config: Any, _level: int) -> Any:
        try:
            changed = read(config)
        except errors as error:
            rospy.logwarn("%s The change is refused; the old parameters stay.", error)
            config.update(accepted)
            return config
        accepted.update(write(changed))
        config.update(accepted)
        apply(changed)
        return config

    return TuningServer(config_type, on_change)


def _given() -> dict[str, Any]:
    """Return the private parameters that are set."""
    given = rospy.get_param("~", {})
    return given if isinstance(given, dict) else {}


def _in(given: Any, name: str, default: Any) -> Any:
    """Return the value of a name in nested namespaces, or the default."""
    for part in name.split("/"):
        if not isinstance(given, dict) or part not in given:
            return default
        given = given[part]
    return given


def _like(default: Any, value: Any) -> Any:
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if isinstance(default, float) and is_number:
        return float(value)
    if isinstance(default, str) and isinstance(value, (int, float)):
        return str(value)
    return value
