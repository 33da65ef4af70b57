"""The metrics of a trial of Experiment 2: its clearance and its flight after the release."""

from __future__ import annotations

import numpy as np

from flights.results.clearance import clearances_along, least
from flights.results.metrics import path_length_m
from flights.worlds.placements import freeze_frame
from master_thesis.experiment_2 import proposals
from master_thesis.experiment_2.description import TrialDescription, flown, in_freeze_frame
from master_thesis.experiment_2.trial import EmergencyTrial


def clearances(description: TrialDescription, trial: EmergencyTrial) -> np.ndarray:
    """Return (n, 2): time, and distance in m from the UAV to the nearest obstacle, from the release on.

    Raises:
        SimulationToolsError: the world or the UAV cannot be loaded.
    """
    poses = flown(trial)
    if trial.freeze is None or not len(poses):
        return np.empty((0, 2))
    frame = freeze_frame(trial.freeze.uav)
    placed = [(obstacle, obstacle.pose(frame)) for obstacle in trial.freeze.obstacles]
    uav = description.model, description.lidar
    return clearances_along(poses, description.world, uav, ignore=("ground_plane",), placed=placed)


def trial_metrics(trial: EmergencyTrial, clearance: np.ndarray) -> dict:
    """Return the metrics from the release to the end."""
    if trial.freeze is None or len(flown(trial)) < 2:
        return {"collision": False, "touched": {}, "min_clearance_m": None, "left": False}
    began_s, poses = trial.freeze.t_s, flown(trial)
    emergencies = [row[0] for row in trial.log.decisions if row[0] > began_s and row[4]]
    last_s = max((row[0] for row in trial.log.decisions), default=began_s)
    went = in_freeze_frame(trial, poses[-1:, 1:4])[0]
    return {
        "collision": bool(trial.touched),
        "touched": {name: t_s - began_s for name, t_s in trial.touched.items()},
        "min_clearance_m": least(clearance),
        "clearance_at_release_m": float(clearance[0, 1]) if len(clearance) else None,
        "left": bool(emergencies) and last_s - emergencies[-1] > 1.0,
        "left_after_s": emergencies[-1] - began_s if emergencies else None,
        "went_xyz_m": went.tolist(),
        "path_length_m": path_length_m(poses[:, 1:4]),
        "observed_s": float(poses[-1, 0]) - began_s,
        "node_answer_xy": node_answer(trial),
    }


def node_answer(trial: EmergencyTrial) -> tuple[float, float] | None:
    """Return the flying CEPA's answer to the first scan, m/s; None if it is missing."""
    if trial.first_scan is None:
        return None
    answers = (row for row in trial.log.v_safe if abs(row[0] - trial.first_scan.t_s) < 1e-6)
    return next(((row[1], row[2]) for row in answers), None)


def proposals_of(description: TrialDescription, trial: EmergencyTrial) -> tuple[proposals.Proposals, ...]:
    """Return both algorithms' proposals for the first scan: with the run's K, then for the sweep."""
    if trial.first_scan is None:
        return ()
    scan = trial.first_scan.scan
    return (proposals.propose(scan, description.cepa), *proposals.sweep(scan, description.cepa))
