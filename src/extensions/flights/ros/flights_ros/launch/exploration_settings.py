"""Checks the file of settings of an exploration: swaps of the battery, the simulator, and SLAM."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from flights.worlds import scenario
from flights_ros.launch.parameter_file import settings_in
from simulation_tools import values

NODES = {
    "experiment": ("swaps",),
    "gazebo": ("static_models", "lockstep_timeout"),
    "gridslam": ("loop_closure",),
}
"""By node: what the file may say. All else has an argument, or is no matter of an exploration."""


def read_file(path: Path) -> dict[str, Any]:
    """Return what a file of settings says to the flight, by name.

    Raises:
        FlightError, ScenarioError: the file cannot be read, or a name in it is unknown, or a flag is none.
        SimulationToolsError: a value makes no sense.
    """
    how = "copy config/exploring.yaml of flights, and give settings:=FILE."
    found = settings_in(path, "The settings of an exploration", how, NODES)
    simulator = found.get("gazebo", {})
    values.number("lockstep_timeout", simulator.get("lockstep_timeout", 10.0), 0.001)
    scenario.flag("static_models", simulator.get("static_models", False))
    scenario.flag("loop_closure", found.get("gridslam", {}).get("loop_closure", True))
    return dict(found.get("experiment", {}))
