"""The request of a pilot's flight."""

from __future__ import annotations

from typing import Any, Mapping

from flights.launch_arguments.common import lidar_of
from flights.launch_arguments.free_places import check_course
from flights.worlds import scenario

DEVICES = ("keyboard", "joy")


def check(asked: Mapping[str, Any]) -> None:
    """Check the arguments of teleop.launch; raises FlightsError or SimulationToolsError."""
    lidar = lidar_of(asked, "iris")
    scenario.choose("algorithm", str(asked["algorithm"]), scenario.ALGORITHMS)
    scenario.choose("device", str(asked["device"]), DEVICES)
    scenario.number("speed", asked["speed"], *scenario.SPEEDS_M_S)
    scenario.whole_number("seed", asked["seed"], *scenario.SEEDS)
    start = scenario.place_and_yaw("start", asked["start"])
    world = scenario.absolute("world", str(asked["world"]))
    check_course(scenario.Scenario(world.stem, world, start), "iris", lidar, (), 0.0)
