"""The request of an exploration."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Mapping

from flights.errors import FlightError
from flights.flight.course import PhaseLimits
from flights.flight.description import RunDescription
from flights.launch_arguments.common import choices_of, limits_of
from flights.launch_arguments.free_places import HOVER_M, check_course
from flights.launch_arguments.nodding import is_true
from flights.launch_arguments.real_uav import HOVER_HEIGHTS_M, check_limits
from flights.worlds import scenario

LONGEST_S = 86_400.0
RETURN_S = 600.0
"""For the ways home and the swaps, beyond the exploration's own time."""


@dataclass(frozen=True)
class ExploringRequest:
    """An exploration.

    limits: of its phases. time_s: after it the UAV comes home. swaps: of the battery, at most. hover_m:
    height over the ground to take off to. sends_hover_height: mavros_publisher waits for it.
    """

    description: RunDescription
    limits: PhaseLimits
    time_s: float
    swaps: int
    hover_m: float = HOVER_M
    sends_hover_height: bool = False


def read(asked: Mapping[str, Any], keep_m: float) -> ExploringRequest:
    """Read and check the request. asked: the node's parameters by name. keep_m: CEPA's r_lb.

    Raises:
        FlightsError, SimulationToolsError: one sentence.
    """
    choices = choices_of({"algorithm": "dynamic", **asked})
    if choices["lidar"] not in scenario.CLOUD_LIDARS and not is_true(asked, "nod"):
        raise FlightError(
            f"Exploring needs clouds, which '{choices['lidar']}' does not give; "
            f"choose lidar:={', '.join(scenario.CLOUD_LIDARS)}, or add nod:=true."
        )
    world = scenario.named_world(str(asked.get("world", "")))
    x, y, z, yaw = scenario.place_and_yaw("start", asked.get("start", "0 0 0 0"))
    flown = scenario.Scenario(world.stem, world, (x, y, z, yaw), (x, y, z + HOVER_M), comes_home=True)
    description = RunDescription(str(asked.get("experiment", "explore")), flown, **choices)
    scenario.number("speed", asked.get("speed", 1.0), *scenario.SPEEDS_M_S)
    time_s = scenario.number("time", asked.get("time", 600.0), 1.0, LONGEST_S)
    swaps = scenario.whole_number("swaps", asked.get("swaps", 1), 0, 100)
    check_limits(str(asked.get("limits", "")).strip())
    limits = limits_of({**asked, "flight_timeout_s": (1 + swaps) * time_s + RETURN_S}, PhaseLimits)
    limits = replace(limits, takes_off_once=True)  # a take-off that ends on the ground would end there again
    given = str(asked.get("hover_height", "")).strip()
    hover_m = scenario.number("hover_height", given, *HOVER_HEIGHTS_M) if given else None
    hover_m = check_course(flown, description.model, description.lidar, [], keep_m, hover_m)
    flown = replace(flown, goal_xyz_m=(x, y, z + hover_m))
    return ExploringRequest(
        replace(description, scenario=flown), limits, time_s, swaps, hover_m, sends_hover_height=not given
    )
