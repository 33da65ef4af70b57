"""Experiments 1 and 4 in the ROS graph, flown by ArduPilot, by real PX4 or by its stand-in."""

from __future__ import annotations

import json
import subprocess
import tempfile
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from benchmarks.simulator.ardupilot_pilots import Programs
from benchmarks.simulator.px4_process import end_px4, start_px4
from flights.errors import GraphError
from flights.graph.free_ports import free_ports
from flights.graph.launched_graph import LaunchedGraph

PATIENCE_S = 1500.0
"""Wall time of a flight on a busy machine."""
FLIGHTS = {
    "forest": ("experiment_1.launch", "scenario:=forest"),
    "hallway": ("experiment_1.launch", "scenario:=hallway"),
    "hold": ("experiment_4.launch",),
}
HEADER = (
    "flight",
    "end",
    "contact",
    "time [s]",
    "way [m]",
    "least clearance [m]",
    "landed off the goal [m]",
    "real-time factor",
)
PORTS = ("simulator_port", "offboard_port", "gcs_port")


def fly(
    flight: str, autopilot: str, programs: Programs, gnss: bool, seed: int, real_time_factor: float
) -> dict[str, Any]:
    """Fly one of FLIGHTS; return what the driver judged.

    Raises GraphError: the flight left no result.
    """
    with tempfile.TemporaryDirectory() as name, ExitStack() as ends:
        folder = Path(name)
        graph = LaunchedGraph(
            folder,
            *("master_thesis", *FLIGHTS[flight], "headless:=true", f"autopilot:={autopilot}"),
            *(f"gnss:={str(gnss).lower()}", f"seed:={seed}", f"real_time_factor:={real_time_factor:g}"),
            *(f"results:={folder / 'results'}", *_own(autopilot, programs)),
        )
        ends.callback(graph.close)
        if autopilot == "px4":
            ends.callback(end_px4, _px4(folder, programs, gnss))
        graph.wait_for_end(PATIENCE_S)
        found = sorted((folder / "results").glob("*/*/result.json"))
        if not found:
            raise GraphError(f"The flight left no result; it said:\n{graph.said()}")
        return json.loads(found[-1].read_text(encoding="utf-8"))


def _own(autopilot: str, programs: Programs) -> list[str]:
    """Return the arguments of a launch that no other program may share."""
    if autopilot == "px4":  # the other ports follow from the number
        return [f"px4_instance:={programs.instance}", f"gcs_port:={free_ports(1)[0]}"]
    ports = [f"{port}:={number}" for port, number in zip(PORTS, free_ports(3))]
    return [*ports, f"ardupilot:={programs.ardupilot}"]


def _px4(folder: Path, programs: Programs, gnss: bool) -> subprocess.Popen[bytes]:
    """Start PX4 beside the launch; it waits for the simulator."""
    assert programs.px4 is not None
    files = folder / "px4"
    files.mkdir()
    return start_px4(programs.px4, programs.instance, files, {}, "iris" if gnss else "iris_vision")


def row(flight: str, place: str, autopilot: str, seed: int, result: dict[str, Any]) -> tuple[str, ...]:
    """Return a flight's line in the table of HEADER."""
    return (
        f"{flight} {place}, {autopilot}, seed {seed}",
        "success" if result["success"] else result["failure"] or "failed",
        "contact" if result["collision"] else "none",
        *(
            "-" if result[key] is None else f"{result[key]:.{digits}f}"
            for key, digits in (
                ("flight_time_s", 1),
                ("path_length_m", 1),
                ("min_clearance_m", 2),
                ("landed_off_goal_m", 2),
                ("real_time_factor", 2),
            )
        ),
    )
