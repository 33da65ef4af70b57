"""Writes a finished run into its results folder. The numbers come first, because the rest may fail."""

from __future__ import annotations

import numpy as np

from flights.flight.course import Outcome
from flights.flight.description import RunDescription
from flights.flight.flight_log import HIT_COLUMNS, HIT_THINNING, FlightLog
from flights.flight.judging.wall_metrics import WallMetrics
from flights.results import clearance
from flights.results.metrics import flight_metrics
from flights.results.run_folder import RunFolder
from flights.results.run_summary import summary_of
from flights.worlds.floor_plan import outlines_of_file
from simulation_tools.errors import SimulationToolsError

FlownRun = tuple[RunFolder, RunDescription, FlightLog, Outcome]


def write_numbers(
    folder: RunFolder, description: RunDescription, log: FlightLog, outcome: Outcome, wall: WallMetrics
) -> dict:
    """Write result.json, still without the clearance, and the CSV series.

    Return the content that result.json will have. While other files are missing, result.json itself tells no
    success. hits.csv holds the ends of lidar beams in `world`.

    Raises:
        ResultsError: a file cannot be written.
    """
    metrics = flight_metrics(log, outcome, description.scenario.goal_xyz_m)
    content = summary_of(description, metrics, wall, min_clearance_m=None)
    folder.write_result(content)
    for name, series in log.series().items():
        folder.write_csv(f"{name}.csv", series.columns, series.rows)
    hits = log.hits(description.lidar_in_body_xyz_m)[::HIT_THINNING]
    folder.write_csv("hits.csv", HIT_COLUMNS, np.round(hits, 3).tolist())
    return {**content, "world_remarks": _world_remarks(description)}


def _world_remarks(description: RunDescription) -> tuple[str, ...]:
    """Return what the simulator warned of at the start: parts of the world that it left out, and the like."""
    from simulation_tools.sdf.parser import load_world
    from simulation_tools.world.shapes.meshes import remarks_on_world

    try:
        return remarks_on_world(load_world(str(description.scenario.world_path)))
    except SimulationToolsError as error:
        return (str(error),)


def complete_run(
    folder: RunFolder,
    description: RunDescription,
    log: FlightLog,
    outcome: Outcome,
    content: dict,
    progress: clearance.Progress = clearance.no_progress,
) -> dict:
    """Add the clearances and the pictures, which take some seconds, to the files of `write_numbers`.

    content: the result of `write_numbers`. Returns the final content of result.json. An interruption leaves
    only complete files.

    Raises:
        ResultsError: a file cannot be written.
        SimulationToolsError: the world or the UAV cannot be loaded again to measure the clearance.
    """
    from flights.results import run_pictures  # matplotlib takes half a second to import

    clearances = clearance.clearances_of_flight(description, log, outcome, progress)
    content = {**content, "min_clearance_m": clearance.least(clearances)}
    folder.write_result(content)
    folder.write_csv("clearance.csv", ("t_s", "clearance_m"), clearances.tolist())
    outlines = outlines_of_file(description.scenario.world_path)
    metrics = flight_metrics(log, outcome, description.scenario.goal_xyz_m)
    run = run_pictures.Run(description, log, outcome, metrics, clearances, outlines)
    run_pictures.write_pictures(folder, run)
    return content
