"""Experiment 1 in two worlds and Experiment 4 in the ROS graph, flown by ArduPilot or by the stand-in."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

from master_thesis.errors import GraphError
from master_thesis.graph.free_ports import free_ports
from master_thesis.graph.launched_graph import LaunchedGraph

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
    "off the goal [m]",
    "real-time factor",
)
PORTS = ("simulator_port", "offboard_port", "gcs_port")


def fly(
    flight: str, autopilot: str, path: str, gnss: bool, seed: int, real_time_factor: float
) -> dict[str, Any]:
    """Fly one of FLIGHTS; return what the driver judged. path: of arducopter.

    Raises GraphError: the flight left no result.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ports = (f"{port}:={number}" for port, number in zip(PORTS, free_ports(3)))
        graph = LaunchedGraph(
            folder,
            *("master_thesis", *FLIGHTS[flight], "headless:=true"),
            *(f"autopilot:={autopilot}", f"ardupilot:={path}", f"gnss:={str(gnss).lower()}"),
            *(
                f"seed:={seed}",
                f"real_time_factor:={real_time_factor:g}",
                f"results:={folder / 'results'}",
                *ports,
            ),
        )
        try:
            graph.wait_for_end(PATIENCE_S)
            found = sorted((folder / "results").glob("*/*/result.json"))
            if not found:
                raise GraphError(f"The flight left no result; it said:\n{graph.said()}")
            return json.loads(found[-1].read_text(encoding="utf-8"))
        finally:
            graph.close()


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
                ("goal_error_m", 2),
                ("real_time_factor", 2),
            )
        ),
    )
