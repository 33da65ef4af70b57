"""Reads a YAML file of parameters as roslaunch does, for the checks before a launch."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Any, Mapping, Sequence

from flights.errors import FlightError
from input_schemas import read_made, structured


def parameters_in(path: Path, what: str, how: str) -> dict[str, Any]:
    """Return the parameters in a file, by name.

    what: the parameters, in words. how: to give a right file, in words.

    Raises:
        FlightError: one sentence.
    """
    import rosparam  # noqa: F401  gives YAML its angles, as for roslaunch
    import yaml

    def made(content: Any) -> dict[str, Any]:
        return structured({} if content is None else content, dict[str, Any], FlightError)

    try:
        return read_made(path, what, made, FlightError, loader=yaml.SafeLoader)
    except FlightError as error:
        raise FlightError(f"{str(error).rstrip('.')}; {how}") from None


def settings_in(
    path: Path, what: str, how: str, nodes: Mapping[str, Sequence[str]]
) -> dict[str, dict[str, Any]]:
    """Return what a file of settings says, by node and name.

    nodes: by node, the names that the file may hold. what, how: as in `parameters_in`.

    Raises:
        FlightError: the file cannot be read, or a name in it is unknown.
    """
    found = parameters_in(path, what, how)
    for node, given in found.items():
        if node not in nodes:
            raise FlightError(f"{path}: {no_such_parameter(str(node), tuple(nodes))}")
        if not isinstance(given, dict):
            raise FlightError(f"{path}: {node} holds no names with values; {how}")
        for name in given:
            if name not in nodes[node]:
                raise FlightError(f"{path}: {node}: {no_such_parameter(str(name), nodes[node])}")
    return found


def no_such_parameter(name: str, known: Sequence[str]) -> str:
    """Return a sentence about a name that is no parameter, with the one that was perhaps meant."""
    close = difflib.get_close_matches(name, known, n=1)
    meant = f"did you mean {close[0]}?" if close else "leave it out."
    return f"There is no parameter {name}; {meant}"
