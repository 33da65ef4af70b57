"""The request of a flight along a mission with SLAM: Experiments 3 and 4."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Mapping

from flight_basics.errors import FlightBasicsError
from flights.errors import ScenarioError
from flights.flight.course import PhaseLimits
from flights.flight.description import RunDescription
from flights.flight.mission_time import MissionTime
from flights.launch_arguments.common import check_pose_source, choices_of, limits_of
from flights.launch_arguments.free_places import check_course
from flights.worlds import scenario
from inspection_tools import Waypoint, hold_s, read_mission, way_m

LONGEST_S = 86_400.0


@dataclass(frozen=True)
class MissionFlight:
    """A flight along a mission.

    limits: of its phases. time: of the mission. mission: its waypoints.
    """

    description: RunDescription
    limits: PhaseLimits
    time: MissionTime
    mission: tuple[Waypoint, ...]


def read(asked: Mapping[str, Any], keep_m: float) -> MissionFlight:
    """Read and check the request. asked: the node's parameters by name.

    keep_m: CEPA's r_lb.

    Raises:
        FlightsError, SimulationToolsError: one sentence.
    """
    choices = choices_of(asked)
    check_pose_source(asked, scenario.MAPPING_POSE_SOURCES)
    world = scenario.absolute("world", str(asked.get("world", "")))
    start = scenario.place_and_yaw("start", asked.get("start", "0 0 0 0"))
    mission = scenario.absolute("mission", str(asked.get("mission", "")))
    waypoints = _waypoints(mission)
    places = [waypoint.position_m for waypoint in waypoints]
    flown = scenario.Scenario(world.stem, world, start, places[-1], mission)
    description = RunDescription(str(asked.get("experiment", "experiment_3")), flown, **choices)
    speed_m_s = scenario.number("speed", asked.get("speed", 1.0), *scenario.SPEEDS_M_S)
    scenario.number("lookahead", asked.get("lookahead", 0.0), *scenario.LOOKAHEADS_S)
    limits = limits_of(asked, PhaseLimits)
    limits = limits.for_way(way_m(waypoints, start[:3]), speed_m_s, hold_s(waypoints))
    duration_s = scenario.number("duration", asked.get("duration", 0.0), 0.0, LONGEST_S)
    check_course(flown, description.model, description.lidar, sorted(set(places)), keep_m)
    returns = scenario.flag("return_to_start", asked.get("return_to_start", False))
    return MissionFlight(description, limits, MissionTime(duration_s or math.inf, returns), waypoints)


def _waypoints(path: Path) -> tuple:
    try:
        return read_mission(path)
    except FlightBasicsError as error:
        raise ScenarioError(str(error)) from None
