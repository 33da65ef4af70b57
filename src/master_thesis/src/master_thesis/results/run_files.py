"""Writes a finished run into its results folder: the numbers first, in case the rest fails."""

from __future__ import annotations

from typing import Callable

from master_thesis.flight.experiment import Outcome
from master_thesis.flight.flight_log import FlightLog
from master_thesis.results import run_report
from master_thesis.results.run_folder import RunFolder
from master_thesis.results.run_report import RunDescription, WallFigures


def write_numbers(
    folder: RunFolder, description: RunDescription, log: FlightLog, outcome: Outcome, wall: WallFigures
) -> dict:
    """Write result.json, still without the clearance, and the CSV series; returns what stands in result.json.

    Raises:
        ResultsError: a file cannot be written.
    """
    merit = run_report.figures_of_merit(log, outcome, description.scenario.goal_xyz_m)
    content = run_report.result(description, merit, wall, min_clearance_m=None)
    folder.write_json("result.json", content)
    run_report.write_series(folder, description, log)
    return content


def complete_run(
    folder: RunFolder,
    description: RunDescription,
    log: FlightLog,
    outcome: Outcome,
    content: dict,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> dict:
    """Add the clearances and the pictures, which take some seconds, to what `write_numbers` wrote.

    content: what it returned. Returns what stands in result.json at the end. May be interrupted at any time:
    each file is complete or not there.

    Raises:
        ResultsError: a file cannot be written.
        SimulationToolsError: the world or the UAV cannot be loaded again to measure the clearance.
    """
    # Physics and matplotlib take a second to import: only here, when the flight is over
    from master_thesis.results import analysis, run_pictures

    clearances = analysis.clearances(description, log, outcome, progress)
    content = {**content, "min_clearance_m": run_report.least(clearances)}
    folder.write_json("result.json", content)
    folder.write_csv("clearance.csv", ("t_s", "clearance_m"), clearances.tolist())
    outlines = analysis.floor_plan(description)
    merit = run_report.figures_of_merit(log, outcome, description.scenario.goal_xyz_m)
    run = run_pictures.Run(description, log, outcome, merit, clearances, outlines)
    run_pictures.write_pictures(folder, run)
    return content
