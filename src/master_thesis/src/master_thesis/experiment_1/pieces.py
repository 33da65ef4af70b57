"""Experiment 1: every scenario by each algorithm with every seed, one flight a piece."""

from __future__ import annotations

from typing import Any

from flights.worlds.experiment_1 import GOAL_X_M
from master_thesis.experiment_1.scenario_flight import WORLDS, fly_scenario, scenario_parameters
from master_thesis.report.piece import Piece, fingerprint
from master_thesis.report.size import Size
from master_thesis.report.thesis import TABLE_8_1_MS

ALGORITHMS = (*TABLE_8_1_MS, "dynamic")
PATH_POSES_PER_S = 20
_COST_S = {"original": 10.0, "improved": 4.0, "dynamic": 6.0}


def pieces(size: Size) -> list[Piece]:
    """Return the pieces of this size."""
    return [
        piece(size, name, algorithm, seed)
        for seed in size.seeds
        for name in size.scenarios
        for algorithm in ALGORITHMS
    ]


def piece(size: Size, name: str, algorithm: str, seed: int) -> Piece:
    """Return one flight."""
    given: dict[str, Any] = {"name": name, "algorithm": algorithm, "seed": seed, "goal_x_m": size.goal_x_m}
    shorter = f"_{size.goal_x_m:g}m" if size.goal_x_m != GOAL_X_M else ""
    return Piece(
        name=f"experiment_1_{name}_{algorithm}_{seed}{shorter}",
        experiment="experiment_1",
        title=f"Experiment 1: {name}, {algorithm}, seed {seed}",
        run=make,
        given=given,
        inputs=fingerprint(scenario_parameters(**given), world=WORLDS / f"{name}.world"),
        cost_s=_COST_S[algorithm],
    )


def make(name: str, algorithm: str, seed: int, goal_x_m: float) -> dict:
    """Fly."""
    flight = fly_scenario(scenario_parameters(name, algorithm, seed, goal_x_m))
    every = max(1, round(len(flight.path) / (PATH_POSES_PER_S * (flight.path[-1, 0] - flight.path[0, 0]))))
    return {
        **flight.metrics,
        "path_xy": flight.path[::every, 1:3].round(3),
        "emergencies_xy": flight.emergencies_xy.round(3),
    }
