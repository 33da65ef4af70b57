"""The path planner and the watch over the energy of a node that flies, from its private parameters."""

from __future__ import annotations

from dataclasses import dataclass, field

import rospy

from exploration.energy import EnergyParameters, EnergyWatch
from exploration.planning import Limits, PathPlanner, PlannerParameters, read_limits
from flight_basics.errors import ParameterError
from input_schemas import structured


@dataclass(frozen=True)
class Groups:
    """Groups of private parameters: ~planner/... and ~energy/..."""

    planner: PlannerParameters = field(default_factory=PlannerParameters)
    energy: EnergyParameters = field(default_factory=EnergyParameters)


def planner_and_watch() -> tuple[PathPlanner, EnergyWatch]:
    """Return them. Parameters (private): limits (str): YAML file; those of `Groups`.

    Raises:
        ParameterError, LimitsError: one sentence.
    """
    given = {name: rospy.get_param(f"~{name}", {}) for name in ("planner", "energy")}
    groups = structured(given, Groups, ParameterError)
    path = rospy.get_param("~limits", "").strip()
    return PathPlanner(groups.planner, read_limits(path) if path else Limits()), EnergyWatch(groups.energy)
