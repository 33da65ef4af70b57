"""Turns a run of Experiment 2 into the files of its results folder."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import numpy as np

from master_thesis.emergency import proposals
from master_thesis.emergency.description import TrialDescription, flown, in_freeze_frame
from master_thesis.emergency.trial import EmergencyTrial
from master_thesis.results import metrics
from master_thesis.results import run_folder as results
from master_thesis.results.sources import commit
from master_thesis.worlds.placements import freeze_frame
from simulation_tools.geometry import Pose

MAX_CLEARANCE_M = 5.0


def clearances(description: TrialDescription, trial: EmergencyTrial) -> np.ndarray:
    """Return (n, 2): time, and distance in m from the UAV's shape to the nearest obstacle's, since let go.

    Raises:
        SimulationToolsError: the world or the UAV cannot be loaded.
    """
    poses = flown(trial)
    if not len(poses):
        return np.empty((0, 2))
    # Physics takes a second to import: only here, when the flight is over
    from simulation_tools.sdf.parser import load_world
    from simulation_tools.uav import load_uav
    from simulation_tools.world.world import PhysicsWorld

    world = PhysicsWorld(load_world(str(description.world)))
    try:
        frame = freeze_frame(trial.freeze.uav)
        for obstacle in trial.freeze.obstacles:
            world.spawn(obstacle.model(), obstacle.name, obstacle.pose(frame))
        uav = load_uav(description.model, description.lidar).model
        world.spawn(uav, "measured", Pose.identity())
        distances = metrics.clearances_m(
            lambda pose: world.clearance("measured", pose, MAX_CLEARANCE_M), poses
        )
    finally:
        world.close()
    return np.column_stack((poses[:, 0], distances))


def result(description: TrialDescription, trial: EmergencyTrial, clearance: np.ndarray) -> dict:
    """Return the content of result.json.

    success: the obstacles were placed, the proposals recorded and the flight watched to its end; and the
    improved algorithm touched nothing. That the original may touch is what this experiment is to show.
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
        **figures_of_merit(trial, clearance),
        "proposals": [asdict(proposal) for proposal in proposals_of(description, trial)],
        "freeze": _freeze(trial),
        "world": description.world,
        "cepa": asdict(description.cepa),
        "parameters": description.parameters,
        "versions": results.versions(),
        "machine": results.machine(),
        "commit": commit(Path(__file__).parent),
    }


def figures_of_merit(trial: EmergencyTrial, clearance: np.ndarray) -> dict:
    """Return what happened from letting go to the end."""
    if trial.freeze is None or len(flown(trial)) < 2:
        return {"collision": False, "touched": {}, "min_clearance_m": None, "left": False}
    began_s, poses = trial.freeze.t_s, flown(trial)
    emergencies = [row[0] for row in trial.log.decisions if row[0] > began_s and row[4]]
    last_s = max((row[0] for row in trial.log.decisions), default=began_s)
    went = in_freeze_frame(trial, poses[-1:, 1:4])[0]
    finite = clearance[np.isfinite(clearance[:, 1]), 1]
    return {
        "collision": bool(trial.touched),
        "touched": {name: t_s - began_s for name, t_s in trial.touched.items()},
        "min_clearance_m": float(finite.min()) if len(finite) else None,
        "clearance_at_release_m": float(clearance[0, 1]) if len(clearance) else None,
        "left": bool(emergencies) and last_s - emergencies[-1] > 1.0,
        "left_after_s": emergencies[-1] - began_s if emergencies else None,
        "went_xyz_m": went.tolist(),
        "path_length_m": metrics.path_length_m(poses[:, 1:4]),
        "observed_s": float(poses[-1, 0]) - began_s,
        "node_answer_xy": node_answer(trial),
    }


def node_answer(trial: EmergencyTrial) -> tuple[float, float] | None:
    """Return what the flying CEPA answered to the first scan, m/s; None if its answer is not there."""
    if trial.first_scan is None:
        return None
    answers = (row for row in trial.log.v_safe if abs(row[0] - trial.first_scan.t_s) < 1e-6)
    return next(((row[1], row[2]) for row in answers), None)


def proposals_of(description: TrialDescription, trial: EmergencyTrial) -> tuple[proposals.Proposals, ...]:
    """Return what both algorithms propose for the first scan: with the run's K, then over the sweep."""
    if trial.first_scan is None:
        return ()
    scan = trial.first_scan.scan
    return (proposals.propose(scan, description.cepa), *proposals.sweep(scan, description.cepa))


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


def write_trial(
    folder: results.RunFolder, description: TrialDescription, trial: EmergencyTrial, thorough: bool = True
) -> dict:
    """Write result.json and the series, and if `thorough` the clearance and the pictures too.

    Returns what stands in result.json.

    Raises:
        ResultsError: a file cannot be written.
        SimulationToolsError: the world or the UAV cannot be loaded to measure the clearance.
    """
    content = result(description, trial, np.empty((0, 2)))
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
    content = result(description, trial, measured)
    folder.write_json("result.json", content)
    from master_thesis.emergency import (
        figures as emergency_figures,  # matplotlib takes half a second to import
    )

    folder.write_files(emergency_figures.pictures(description, trial, content))
    return content


def _write_scan(folder: results.RunFolder, trial: EmergencyTrial) -> None:
    scan = trial.first_scan.scan
    angles = scan.angle_min + np.arange(scan.ranges.size) * scan.angle_increment
    rows = [(float(a), float(r), int(s)) for a, r, s in zip(angles, scan.ranges, scan.seen)]
    folder.write_csv("first_scan.csv", ("angle_rad", "range_m", "seen"), rows)


def headline(content: dict) -> str:
    """Return a run's figures in a few lines for a terminal."""
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
        rows["left"] = f"after {content['left_after_s']:.1f} s" if content["left"] else "no"
    if content["failure"]:
        rows["failure"] = content["failure"]
    return "\n".join(f"  {name:<22} {value}" for name, value in rows.items())


def _velocity(velocity_xy) -> str:
    x, y = velocity_xy
    return f"{x:+.2f} m/s ahead, {y:+.2f} m/s to the left"
