"""CEPA's parameters in ROS: a flat mapping that holds the algorithm's name, too."""

from __future__ import annotations

import dataclasses
from typing import Any, Callable, Mapping, NamedTuple

from cepa import ALGORITHMS, CepaParameters, ParameterError
from cepa.algorithm import Algorithm
from node_tools import parameters as ros_parameters


class Choice(NamedTuple):
    """An algorithm and its parameters."""

    algorithm: str
    parameters: CepaParameters


def choice_of(config: Mapping[str, Any]) -> Choice:
    """Return the choice in a mapping that names all parameters, such as dynamic_reconfigure's.

    Raises:
        ParameterError: a value makes no sense, alone or with the others.
    """
    algorithm = config["algorithm"]
    if algorithm not in ALGORITHMS:
        raise ParameterError(f"algorithm is {algorithm!r}; it must be one of {', '.join(ALGORITHMS)}.")
    values = {field.name: config[field.name] for field in dataclasses.fields(CepaParameters)}
    values["speed_fractions"] = _fractions(values["speed_fractions"])
    return Choice(algorithm, CepaParameters(**values))


def algorithm_of(choice: Choice) -> Algorithm:
    """Return a new instance of the chosen algorithm."""
    return ALGORITHMS[choice.algorithm](choice.parameters)


def config_of(choice: Choice) -> dict[str, Any]:
    """Return the mapping that `choice_of` reads."""
    config = dataclasses.asdict(choice.parameters)
    config["speed_fractions"] = " ".join(f"{fraction:g}" for fraction in choice.parameters.speed_fractions)
    return {"algorithm": choice.algorithm, **config}


def read_choice() -> Choice:
    """Return the choice that the private ROS parameters make.

    Raises:
        ParameterError: as `choice_of`.
    """
    choice = choice_of(ros_parameters.read_values(config_of(Choice("improved", CepaParameters()))))
    ros_parameters.write_values(config_of(choice))
    return choice


def serve_choice(config_type: Any, choice: Choice, apply: Callable[[Choice], None]) -> Any:
    """Return a dynamic_reconfigure server that calls `apply` with each new choice."""
    return ros_parameters.serve(config_type, choice, choice_of, config_of, apply, ParameterError)


def _fractions(value: Any) -> tuple[float, ...]:
    """Read "1.0 0.75", "1.0, 0.75", a number or a list."""
    if isinstance(value, str):
        value = value.replace(",", " ").split()
    elif isinstance(value, (int, float)):
        value = [value]
    try:
        return tuple(float(fraction) for fraction in value)
    except (TypeError, ValueError):
        raise ParameterError(
            f"speed_fractions must be numbers in (0, 1] such as '1.0 0.5', not {value!r}."
        ) from None
