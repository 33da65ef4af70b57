"""CEPA's parameters, from the arguments of a launch file or from a running graph."""

from __future__ import annotations

from typing import Any, Mapping

from cepa.errors import CepaError
from cepa.parameters import CepaParameters  # not all of cepa, which loads numba
from flights.errors import FlightError
from flights.worlds import scenario

RADII_M = (0.05, 5.0)


def cepa_keeps_m(parameters: Mapping[str, Any]) -> float:
    """Return the distance, m, that CEPA keeps from obstacles, from its parameters."""
    return _given_m(parameters, "r_lb", CepaParameters.r_lb)


def cepa_body_m(parameters: Mapping[str, Any]) -> float:
    """Return the radius, m, of the body that CEPA keeps off, from its parameters."""
    return _given_m(parameters, "body_radius", CepaParameters.body_radius)


def _given_m(parameters: Mapping[str, Any], name: str, default: float) -> float:
    given = parameters.get(name, default)
    return float(given) if isinstance(given, (int, float)) else default


def led_r_lb_m(asked: Mapping[str, Any]) -> float:
    """Return r_lb as led_flight.launch sets it for the argument `radius`; raises ScenarioError."""
    radius_m = scenario.number("radius", asked.get("radius", 0.35), *RADII_M)
    return radius_m + (0.02 if radius_m < 0.3 else 0.15)


def cepa_of(asked: Mapping[str, Any], names: Mapping[str, str]) -> CepaParameters:
    """Return CEPA's parameters with the requested values. names: of the arguments, by parameter.

    Raises:
        FlightError: one sentence.
    """
    given = {parameter: asked[name] for parameter, name in names.items() if name in asked}
    try:
        return CepaParameters(**{parameter: _number(value) for parameter, value in given.items()})
    except CepaError as error:
        raise FlightError(str(error)) from None


def _number(value: Any) -> Any:
    try:
        return float(value)
    except (TypeError, ValueError):
        return value
