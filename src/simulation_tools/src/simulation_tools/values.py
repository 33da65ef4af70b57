"""Checks of user input: parameters of a node, arguments of a launch file."""

from __future__ import annotations

import math
from typing import Any, Sequence

from simulation_tools.bounds import MAX_MAGNITUDE
from simulation_tools.errors import SimulationToolsError

AUTOPILOTS = ("standin", "px4", "ardupilot")
PORT_MAX = 65535


class ParameterError(SimulationToolsError):
    """A parameter of a node cannot be used."""


def number(name: str, given: Any, least: float = -MAX_MAGNITUDE, most: float = MAX_MAGNITUDE) -> float:
    """Return the given value as a number within limits; ParameterError otherwise."""
    try:
        value = float(given)
    except (TypeError, ValueError):
        value = math.nan
    if not least <= value <= most:
        raise ParameterError(
            f"The parameter {name} must be a number from {least:g} to {most:g}, not {given!r}."
        )
    return value


def port(name: str, given: Any) -> int:
    """Return the given value as a UDP or TCP port; 0: any that is free. ParameterError otherwise."""
    try:
        value = float(given)
    except (TypeError, ValueError):
        value = math.nan
    if not (0.0 <= value <= PORT_MAX and value.is_integer()):
        raise ParameterError(f"The parameter {name} must be a port, 0 to {PORT_MAX}, not {given!r}.")
    return int(value)


def mavlink_ports(offboard: Any, ground_station: Any) -> tuple[int, int]:
    """Return the UDP ports to which the flight controller sends: to MAVROS, and to a ground station.

    Raises:
        ParameterError: one is not a port, or both are the same: MAVROS would hear everything twice.
    """
    ports = port("offboard_port", offboard), port("gcs_port", ground_station)
    if ports[0] == ports[1] != 0:
        raise ParameterError(f"offboard_port and gcs_port are both {ports[0]}; give each a port of its own.")
    return ports


def choice(name: str, given: str, choices: Sequence[str]) -> str:
    """Return the given value if it is one of the choices; ParameterError otherwise."""
    if given not in choices:
        raise ParameterError(f'There is no {name} "{given}"; choose one of {", ".join(choices)}.')
    return given
