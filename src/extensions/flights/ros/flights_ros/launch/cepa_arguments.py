"""Checks a YAML file of CEPA's parameters, as its node does."""

from __future__ import annotations

from pathlib import Path

from flights.errors import FlightError
from flights_ros.launch.parameter_file import no_such_parameter, parameters_in


def check_file(path: Path) -> None:
    """Check the parameters in a file; raises FlightError.

    A misspelt name is refused, because it would have no effect.
    """
    from cepa_ros.parameters import Choice, choice_of, config_of  # takes a quarter of a second

    from cepa import CepaError, CepaParameters
    from node_tools.parameters import exponents_as_text  # loads rospy

    how = "give a YAML file of CEPA's parameters with cepa_config:=FILE."
    written = parameters_in(path, "CEPA's parameters", how)
    defaults = config_of(Choice("improved", CepaParameters()))
    cannot = f"CEPA cannot fly with cepa_config:={path}"
    for name in written:
        if name not in defaults:
            raise FlightError(f"{cannot}: {no_such_parameter(name, list(defaults))}")
    try:
        choice_of({**defaults, **written})
    except CepaError as error:
        raise FlightError(f"{cannot}: {error} {exponents_as_text(written)}".strip()) from None
