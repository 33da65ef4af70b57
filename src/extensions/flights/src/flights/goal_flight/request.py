"""The request of a flight to one goal: Experiment 1, and flights in a user's own world."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Mapping

from flights.errors import ScenarioError
from flights.flight.course import PhaseLimits
from flights.flight.description import RunDescription
from flights.launch_arguments.common import check_pose_source, choices_of, limits_of
from flights.launch_arguments.free_places import check_course
from flights.worlds import scenario


@dataclass(frozen=True)
class GoalFlight:
    """A flight to one goal, and the limits of its phases. is_planned: path_planner leads the UAV."""

    description: RunDescription
    limits: PhaseLimits
    is_planned: bool = False


def read(asked: Mapping[str, Any], keep_m: float) -> GoalFlight:
    """Read and check the request. asked: the node's parameters by name.

    keep_m: CEPA's r_lb.

    Raises:
        FlightsError, SimulationToolsError: one sentence.
    """
    name = str(asked.get("scenario", ""))
    if name:
        scenario.choose("scenario", name, scenario.SCENARIOS)
    choices = choices_of(asked)
    avoidance = str(asked.get("avoidance", scenario.CEPA))
    is_planned = str(asked.get("planner", "false")).lower() in ("true", "1")
    check_pose_source(asked, ("slam",) if is_planned else scenario.POSE_SOURCES)
    if is_planned and (choices["lidar"] not in scenario.CLOUD_LIDARS or avoidance != scenario.CEPA):
        raise ScenarioError(
            "planner:=true maps in three dimensions and flies with CEPA: give a lidar with clouds "
            f"({', '.join(scenario.CLOUD_LIDARS)}), and no other avoidance."
        )
    world = scenario.absolute("world", str(asked.get("world", "")))
    start = scenario.place_and_yaw("start", asked.get("start", "0 0 0 0"))
    goal = scenario.place("goal", asked.get("goal", "40 0 2"))
    flown = scenario.Scenario(name or world.stem, world, start, goal)
    description = RunDescription(str(asked.get("experiment", "experiment_1")), flown, **choices)
    if avoidance != scenario.CEPA:
        description = replace(description, algorithm=avoidance.split()[-1])
    speed_m_s = scenario.number("speed", asked.get("speed", 2.0), *scenario.SPEEDS_M_S)
    limits = limits_of(asked, PhaseLimits)
    limits = limits.for_way(math.dist(start[:2], goal[:2]), speed_m_s)
    if not name:  # the places of Experiment 1 are known to be free
        check_course(
            flown, description.model, description.lidar, [goal], keep_m if avoidance == scenario.CEPA else 0.0
        )
    return GoalFlight(description, limits, is_planned)
