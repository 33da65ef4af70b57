"""Writes a trial of Experiment 2 into its results folder."""

from __future__ import annotations

import numpy as np

from cepa import LaserScan2D
from flights.results.run_folder import RunFolder
from master_thesis.experiment_2.description import TrialDescription
from master_thesis.experiment_2.metrics import clearances
from master_thesis.experiment_2.summary import summary_of
from master_thesis.experiment_2.trial import EmergencyTrial


def write_numbers(folder: RunFolder, description: TrialDescription, trial: EmergencyTrial) -> dict:
    """Write result.json, still without the clearance, and the series. Return the content of result.json.

    Raises:
        ResultsError: a file cannot be written.
    """
    content = summary_of(description, trial, np.empty((0, 2)))
    folder.write_result(content)
    for name, series in trial.log.series().items():
        folder.write_csv(f"{name}.csv", series.columns, series.rows)
    if trial.first_scan is not None:
        _write_scan(folder, trial.first_scan.scan)
    return content


def complete_trial(folder: RunFolder, description: TrialDescription, trial: EmergencyTrial) -> dict:
    """Add the clearance and the pictures, which take some seconds. Return the content of result.json.

    Raises:
        ResultsError: a file cannot be written.
        SimulationToolsError: the world or the UAV cannot be loaded again.
    """
    if trial.freeze is None or trial.first_scan is None:
        return summary_of(description, trial, np.empty((0, 2)))
    measured = clearances(description, trial)
    folder.write_csv("clearance.csv", ("t_s", "clearance_m"), measured.tolist())
    content = summary_of(description, trial, measured)
    folder.write_result(content)
    from master_thesis.experiment_2.pictures import pictures  # matplotlib takes half a second to import

    folder.write_files(pictures(description, trial, content))
    return content


def _write_scan(folder: RunFolder, scan: LaserScan2D) -> None:
    angles = scan.angle_min + np.arange(scan.ranges.size) * scan.angle_increment
    seen = np.ones(scan.ranges.size) if scan.seen is None else scan.seen
    rows = [(float(a), float(r), int(s)) for a, r, s in zip(angles, scan.ranges, seen)]
    folder.write_csv("first_scan.csv", ("angle_rad", "range_m", "seen"), rows)
