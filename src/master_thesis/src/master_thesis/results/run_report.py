"""Turns a flight's log and outcome into the files of its results folder."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable

import numpy as np

from master_thesis.flight.experiment import Outcome, Phase
from master_thesis.flight.flight_log import HIT_COLUMNS, FlightLog
from master_thesis.results import metrics
from master_thesis.results import run_folder as results
from master_thesis.results.sources import commit
from master_thesis.worlds.scenario import ALGORITHMS, Scenario

CLEARANCE_SPACING_M = 0.02
MAX_CLEARANCE_M = 5.0
HIT_THINNING = 4  # every fourth beam of the kept scans goes into hits.csv and the pictures


@dataclass(frozen=True)
class RunDescription:
    """What was run. parameters: every node's parameters by node name; algorithm, lidar: as chosen."""

    experiment: str
    scenario: Scenario
    algorithm: str
    lidar: str
    seed: int
    model: str = "iris"
    parameters: dict[str, dict] = field(default_factory=dict)
    lidar_in_body_xyz_m: tuple = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class WallFigures:
    """What only a run in wall time has.

    real_time_factor: simulated over wall seconds from the goal's sending to its being reached. latency_ms:
    median and p99 from publishing a scan to the flight controller's receiving the setpoint made from it,
    and their count. lockstep_misses: barriers that timed out. wall_time_s: of the whole run.
    """

    real_time_factor: float | None = None
    latency_ms: dict | None = None
    lockstep_misses: int | None = None
    wall_time_s: float | None = None
    wall_time_to_ready_s: float | None = None


def figures_of_merit(log: FlightLog, outcome: Outcome, goal_xyz_m: tuple) -> dict:
    """Return what the log alone says of the flight, from sending the goal to reaching it.

    A flight that did not reach it is measured up to its end.
    """
    start_s, end_s = flight_interval_s(log, outcome)
    flown = log.between(start_s, end_s)
    decisions = [row for row in log.decisions if start_s <= row[0] <= end_s]
    final = log.between(end_s, outcome.times_s.get(Phase.LANDING, end_s))
    goal_error = np.linalg.norm(final[-1, 1:4] - np.array(goal_xyz_m)) if len(final) else None
    return {
        "reached_goal": outcome.reached_goal,
        "collision": outcome.collision,
        "landed": outcome.landed,
        "success": outcome.success,
        "failure": outcome.failure,
        "touched": outcome.touched,
        "flight_time_s": end_s - start_s if outcome.reached_goal else None,
        "path_length_m": metrics.path_length_m(flown[:, 1:4]),
        "goal_error_m": goal_error,
        "cepa_computation_ms": metrics.summary([row[1] for row in decisions]),
        "cepa_directions_tested": metrics.summary([row[2] for row in decisions]),
        "emergencies": sum(bool(row[4]) for row in decisions),
        "times_s": {phase.name.lower(): t_s for phase, t_s in outcome.times_s.items()},
    }


def flight_interval_s(log: FlightLog, outcome: Outcome) -> tuple:
    """Return when the goal was sent and when it was reached (or the log's end), in seconds."""
    times = outcome.times_s
    last_s = log.truth.rows[-1][0] if len(log.truth) else 0.0
    start_s = times.get(Phase.FLYING, last_s)
    if outcome.reached_goal:
        return start_s, times[Phase.HOVERING]
    return start_s, times.get(Phase.LANDING, times.get(Phase.DONE, last_s))


def clearance_series(log: FlightLog, outcome: Outcome, clearance: Callable, progress: Callable) -> np.ndarray:
    """Return (n, 2): time and distance to the nearest obstacle, from sending the goal to landing.

    clearance: distance in metres of the UAV at a pose to the nearest shape but the ground.
    """
    start_s, end_s = flight_interval_s(log, outcome)
    end_s = outcome.times_s.get(Phase.LANDING, end_s)
    poses = metrics.thinned(log.between(start_s, end_s), CLEARANCE_SPACING_M)
    return np.column_stack((poses[:, 0], metrics.clearances_m(clearance, poses, progress)))


def least(clearances: np.ndarray) -> float | None:
    """Return the least of the clearances (n, 2), or None when nothing came nearer than was looked for."""
    finite = clearances[np.isfinite(clearances[:, 1]), 1] if len(clearances) else []
    return float(np.min(finite)) if len(finite) else None


def result(description: RunDescription, merit: dict, wall: WallFigures, min_clearance_m) -> dict:
    """Return the content of result.json."""
    scenario = description.scenario
    return {
        "experiment": description.experiment,
        "scenario": scenario.name,
        "algorithm": description.algorithm,
        "lidar": description.lidar,
        "seed": description.seed,
        **merit,
        "min_clearance_m": min_clearance_m,
        **vars(wall),
        "world": scenario.world_path,
        "start": scenario.start_xyz_yaw,
        "goal": scenario.goal_xyz_m,
        "mission": scenario.mission_path,
        "parameters": description.parameters,
        "versions": results.versions(),
        "machine": results.machine(),
        "commit": commit(Path(__file__).parent),
    }


def write_series(folder: results.RunFolder, description: RunDescription, log: FlightLog) -> None:
    """Write every time series as NAME.csv, and hits.csv: where lidar beams ended, in `world`."""
    for name, series in log.series().items():
        folder.write_csv(f"{name}.csv", series.columns, series.rows)
    hits = log.hits(description.lidar_in_body_xyz_m)[::HIT_THINNING]
    folder.write_csv("hits.csv", HIT_COLUMNS, np.round(hits, 3).tolist())


def steering(algorithm: str) -> str:
    """Return in words who kept the UAV off the obstacles: CEPA, or a node of the user's own."""
    return f"{algorithm} CEPA" if algorithm in ALGORITHMS else algorithm


def headline(content: dict) -> str:
    """Return a run's figures in a few lines for a terminal."""
    computation = content["cepa_computation_ms"] or {}
    latency = content["latency_ms"] or {}
    rows = {
        "scenario": "{scenario}, {steering}, {lidar}, seed {seed}".format(
            steering=steering(content["algorithm"]), **content
        ),
        "reached goal": "yes" if content["reached_goal"] else "no",
        "collision": "yes" if content["collision"] else "no",
        "flight time": _in_unit("s", 1, content["flight_time_s"]),
        "path length": _in_unit("m", 1, content["path_length_m"]),
        "least clearance": _in_unit("m", 2, content["min_clearance_m"]),
        "CEPA, mean, p99": _in_unit("ms", 3, computation.get("mean"), computation.get("p99")),
        "latency, median, p99": _in_unit("ms", 1, latency.get("median"), latency.get("p99")),
        "real-time factor": _in_unit("", 3, content["real_time_factor"]),
    }
    if content["failure"]:
        rows["failure"] = content["failure"]
    return "\n".join(f"  {name:<22} {value}" for name, value in rows.items())


def _in_unit(unit: str, digits: int, *values: float | None) -> str:
    written = ["-" if value is None else f"{value:.{digits}f} {unit}".strip() for value in values]
    return ", ".join(written)
