"""The path planner and the watch over the energy of a node that flies, from its private parameters."""

from __future__ import annotations

from typing import TypeVar

import rospy

from exploration.energy import EnergyParameters, EnergyWatch
from exploration.planning import Limits, PathPlanner, PlannerParameters, read_limits
from flight_basics.errors import ParameterError
from input_schemas import structured

Parameters = TypeVar("Parameters")


def planner_and_watch() -> tuple[PathPlanner, EnergyWatch]:
    """Return them. Parameters (private): limits (str): YAML file; planner/..., energy/...

    Raises:
        ParameterError, LimitsError: one sentence.
    """
    planner, energy = read_group("~planner", PlannerParameters), read_group("~energy", EnergyParameters)
    path = rospy.get_param("~limits", "").strip()
    return PathPlanner(planner, read_limits(path) if path else Limits()), EnergyWatch(energy)


def read_group(group: str, parameter_class: type[Parameters]) -> Parameters:
    """Return a group of private parameters as a dataclass that checks itself.

    Raises:
        ParameterError: one sentence: a name is unknown, or a value makes no sense.
    """
    try:
        return structured(rospy.get_param(group, {}), parameter_class, ParameterError)
    except ParameterError as error:
        raise ParameterError(f"{group}: {error}") from None
