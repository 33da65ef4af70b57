"""Checks the arguments of a flight whose lidar nods."""

from __future__ import annotations

from typing import Any, Mapping

from flights.errors import ScenarioError
from flights.worlds import scenario
from simulation_tools import values
from simulation_tools.vehicle.nod import Nod

MOST_SWEEPS = 100


def check(asked: Mapping[str, Any]) -> None:
    """Check `nod` of a mission, and what goes with it.

    Raises:
        ScenarioError, SimulationToolsError: one sentence.
    """
    if not is_true(asked, "nod"):
        return
    check_lidar(asked)
    if not is_true(asked, "volume"):
        raise ScenarioError("A lidar nods for the map in three dimensions; add volume:=true to nod:=true.")
    if is_true(asked, "lockstep"):
        raise ScenarioError(
            "When the lidar nods depends on the machine's speed, so the flight would not repeat; leave out "
            "lockstep:=true."
        )


def check_lidar(asked: Mapping[str, Any]) -> None:
    """Check that a lidar may nod, and that the gimbal of the UAV can follow.

    Raises:
        ScenarioError, SimulationToolsError: one sentence.
    """
    from simulation_tools.vehicle.gimbal import Gimbal
    from simulation_tools.vehicle.uav import load_uav

    lidar, model = str(asked["lidar"]), str(asked.get("model", "iris"))
    if lidar in scenario.CLOUD_LIDARS:
        raise ScenarioError(f"lidar:={lidar} need not nod, because it has a cloud; leave out nod:=true.")
    if is_true(asked, "level_lidar"):
        raise ScenarioError("The gimbal either levels the lidar or nods; leave out level_lidar:=true.")
    nod = Nod(
        values.number("nod_amplitude", asked["nod_amplitude"], 0.0),
        values.number("nod_period", asked["nod_period"], 0.0),
        scenario.whole_number("nod_sweeps", asked["nod_sweeps"], 1, MOST_SWEEPS),
    )
    gimbal = Gimbal.from_sdf(load_uav(model).model)
    if gimbal is None:
        raise ScenarioError(f"The model {model} has no gimbal, so its lidar cannot nod.")
    gimbal.start_nod(nod)


def is_true(asked: Mapping[str, Any], name: str) -> bool:
    """Return whether a flag is set; one that is not there is not."""
    return str(asked.get(name, "false")).lower() == "true"
