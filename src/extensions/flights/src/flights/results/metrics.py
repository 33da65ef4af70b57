"""The metrics of a flight, for result.json."""

from __future__ import annotations

import math

import numpy as np

from flights.flight.course import Outcome, Phase
from flights.flight.flight_log import FlightLog


def flight_metrics(log: FlightLog, outcome: Outcome, goal_xyz_m: tuple[float, float, float]) -> dict:
    """Return the metrics of the log, from sending the goal to reaching it.

    A flight that did not reach it is measured up to its end.
    """
    start_s, end_s = flight_interval_s(log, outcome)
    flown = log.between(start_s, end_s)
    decisions = [row for row in log.decisions if start_s <= row[0] <= end_s]
    final = log.between(end_s, outcome.times_s.get(Phase.LANDING, end_s))
    goal_error = np.linalg.norm(final[-1, 1:4] - np.array(goal_xyz_m)) if len(final) else None
    landing = outcome.landing
    standing_xy_m = log.truth.rows[-1][1:3] if landing is not None else None
    return {
        "reached_goal": outcome.reached_goal,
        "collision": outcome.collision,
        "landed": outcome.landed,
        "success": outcome.success,
        "failure": outcome.failure,
        "touched": outcome.touched,
        "flight_time_s": end_s - start_s if outcome.reached_goal else None,
        "path_length_m": path_length_m(flown[:, 1:4]),
        "goal_error_m": goal_error,
        "landed_off_goal_m": None if standing_xy_m is None else math.dist(standing_xy_m, goal_xyz_m[:2]),
        "landing_error_m": None if landing is None else landing.landing_error_m,
        "landing": None if landing is None else landing.figures(),
        "cepa_computation_ms": statistics_of([row[1] for row in decisions]),
        "cepa_directions_tested": statistics_of([row[2] for row in decisions]),
        "emergencies": sum(bool(row[4]) for row in decisions),
        "times_s": {phase.name.lower(): t_s for phase, t_s in outcome.times_s.items()},
    }


def flight_interval_s(log: FlightLog, outcome: Outcome) -> tuple[float, float]:
    """Return the times of sending the goal and of reaching it (or of the log's end), in seconds."""
    times = outcome.times_s
    last_s = log.truth.rows[-1][0] if len(log.truth) else 0.0
    start_s = times.get(Phase.FLYING, last_s)
    if outcome.reached_goal:
        return start_s, times[Phase.HOVERING]
    return start_s, times.get(Phase.LANDING, times.get(Phase.DONE, last_s))


def path_length_m(positions_xyz: np.ndarray) -> float:
    """Return the length in metres of the polyline through positions (n, 3)."""
    if len(positions_xyz) < 2:
        return 0.0
    return float(np.linalg.norm(np.diff(positions_xyz, axis=0), axis=1).sum())


def statistics_of(values: np.ndarray | list) -> dict | None:
    """Return mean, median, 99th percentile, maximum and count of values (n,), or None if there are none."""
    found = np.asarray(values, dtype=float)
    found = found[np.isfinite(found)]
    if not len(found):
        return None
    return {
        "mean": float(found.mean()),
        "median": float(np.median(found)),
        "p99": float(np.percentile(found, 99)),
        "max": float(found.max()),
        "count": len(found),
    }
