"""The summary of a trial of Experiment 2: the content of its result.json, and its headline for a terminal."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Sequence

import numpy as np

from flights.results import run_folder
from flights.results.sources import commit
from master_thesis.experiment_2.description import TrialDescription, flown
from master_thesis.experiment_2.metrics import proposals_of, trial_metrics
from master_thesis.experiment_2.trial import EmergencyTrial


def summary_of(description: TrialDescription, trial: EmergencyTrial, clearance: np.ndarray) -> dict:
    """Return the content of result.json.

    success: the obstacles were placed, the proposals recorded and the flight watched to its end, and the
    improved algorithm touched nothing. The original one may touch obstacles. The experiment shows exactly
    this.
    """
    failure = trial.failure
    if failure is None and trial.touched and description.algorithm == "improved":
        failure = f"The UAV touched {', '.join(trial.touched)}."
    return {
        "experiment": description.experiment,
        "scenario": description.scenario,
        "algorithm": description.algorithm,
        "k_filter": description.cepa.k_filter,
        "lidar": description.lidar,
        "seed": description.seed,
        "success": failure is None,
        "failure": failure,
        **trial_metrics(trial, clearance),
        "proposals": [asdict(proposal) for proposal in proposals_of(description, trial)],
        "freeze": _freeze(trial),
        "world": description.world,
        "cepa": asdict(description.cepa),
        "parameters": description.parameters,
        "versions": run_folder.versions(),
        "machine": run_folder.machine(),
        "commit": commit(Path(__file__).parent),
    }


def _freeze(trial: EmergencyTrial) -> dict | None:
    if trial.freeze is None:
        return None
    freeze, poses = trial.freeze, flown(trial)
    delay_s = moved_m = None
    if trial.first_scan is not None:
        delay_s = trial.first_scan.t_s - freeze.t_s
        then = [np.interp(trial.first_scan.t_s, poses[:, 0], poses[:, axis]) for axis in (1, 2, 3)]
        moved_m = float(np.linalg.norm(np.array(then) - freeze.uav.position_m))
    return {
        "t_s": freeze.t_s,
        "uav_xyz_m": freeze.uav.position_m,
        "uav_yaw_rad": freeze.uav.yaw_rad,
        "first_scan_after_s": delay_s,
        "moved_until_first_scan_m": moved_m,
        "obstacles": [
            {"name": o.name, "shape": asdict(o.shape), "x_m": o.x_m, "y_m": o.y_m} for o in freeze.obstacles
        ],
    }


def headline(content: dict) -> str:
    """Return a trial's metrics in a few lines for a terminal."""
    rows = {"scenario": "{scenario}, {algorithm} CEPA, K = {k_filter:g} m/rad, {lidar}".format(**content)}
    if content["proposals"]:
        proposed = content["proposals"][0]
        rows["original proposes"] = _velocity(proposed["original_xy"])
        rows["improved proposes"] = f"{_velocity(proposed['improved_xy'])} ({proposed['reason']})"
    if content["collision"]:
        name, after_s = next(iter(content["touched"].items()))
        rows["touched"] = f"{name} after {after_s:.1f} s"
    else:
        rows["touched"] = "nothing"
    if content["min_clearance_m"] is not None:
        rows["least clearance"] = f"{max(content['min_clearance_m'], 0.0):.3f} m"
        away = f"after {content['left_after_s']:.1f} s; no emergency since"
        rows["got away"] = away if content["left"] else "no: the emergency lasted until the end"
    if content["failure"]:
        rows["failure"] = content["failure"]
    return "\n".join(f"  {name:<22} {value}" for name, value in rows.items())


def _velocity(velocity_xy: Sequence[float]) -> str:
    """Return a velocity of the body (x ahead, y left) in words."""
    x, y = (round(value, 2) for value in velocity_xy)
    along, across = "back" if x < 0.0 else "ahead", "right" if y < 0.0 else "left"
    return f"{abs(x):.2f} m/s {along}, {abs(y):.2f} m/s to the {across}"
