"""Checks the file of settings of an inspection: camera, how photographs are planned, and the simulator."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from flights.errors import FlightError
from flights_ros.launch.parameter_file import settings_in
from simulation_tools import values

CAMERA = ("width", "height", "field_of_view", "exposure", "lamp", "defects")
NODES = {
    "camera": CAMERA,
    "camera_mavlink": CAMERA,
    "experiment": (*CAMERA, "search", "draft", "supplement", "second_look", "swaps"),
    "gazebo": ("static_models", "lockstep_timeout"),
    "gridslam": ("loop_closure",),
}
"""By node: what the file may say. All else has an argument, or is no matter of an inspection."""
SAME = ("width", "height", "field_of_view", "exposure", "defects")
"""What the flight and its plan take from the camera."""


def read_file(path: Path) -> dict[str, Any]:
    """Return what a file of settings says to the flight, by name.

    Raises:
        FlightError: the file cannot be read, or a name in it is unknown.
        SimulationToolsError: a value makes no sense.
    """
    how = "copy config/inspecting.yaml of flights, and give settings:=FILE."
    found = settings_in(path, "The settings of an inspection", how, NODES)
    flight, camera = found.get("experiment", {}), found.get("camera", {})
    for name in SAME:
        if flight.get(name) != camera.get(name):
            raise FlightError(
                f"{path}: {name} is {camera.get(name)} for the camera and {flight.get(name)} for the flight; "
                "keep the line '<<: *camera' below 'experiment:'."
            )
    values.number("lockstep_timeout", found.get("gazebo", {}).get("lockstep_timeout", 30.0), 0.001)
    return dict(flight)
