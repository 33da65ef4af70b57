"""Writes a trial of Experiment 2 into its results folder."""

from __future__ import annotations

import numpy as np

from master_thesis.experiment_2.description import TrialDescription
from master_thesis.experiment_2.metrics import clearances
from master_thesis.experiment_2.summary import summary_of
from master_thesis.experiment_2.trial import EmergencyTrial
from master_thesis.results.run_folder import RunFolder


def write_trial(
    folder: RunFolder, description: TrialDescription, trial: EmergencyTrial, thorough: bool = True
) -> dict:
    """Write result.json and the series, and if `thorough` the clearance and the pictures too.

    Returns what stands in result.json.

    Raises:
        ResultsError: a file cannot be written.
        SimulationToolsError: the world or the UAV cannot be loaded to measure the clearance.
    """
    content = summary_of(description, trial, np.empty((0, 2)))
    folder.write_json("result.json", content)
    for name, series in trial.log.series().items():
        folder.write_csv(f"{name}.csv", series.columns, series.rows)
    if trial.freeze is None or trial.first_scan is None:
        return content
    _write_scan(folder, trial)
    if not thorough:
        return content
    measured = clearances(description, trial)
    folder.write_csv("clearance.csv", ("t_s", "clearance_m"), measured.tolist())
    content = summary_of(description, trial, measured)
    folder.write_json("result.json", content)
    from master_thesis.experiment_2.pictures import pictures  # matplotlib takes half a second to import

    folder.write_files(pictures(description, trial, content))
    return content


def _write_scan(folder: RunFolder, trial: EmergencyTrial) -> None:
    scan = trial.first_scan.scan
    angles = scan.angle_min + np.arange(scan.ranges.size) * scan.angle_increment
    rows = [(float(a), float(r), int(s)) for a, r, s in zip(angles, scan.ranges, scan.seen)]
    folder.write_csv("first_scan.csv", ("angle_rad", "range_m", "seen"), rows)
