"""Experiment 2: both algorithms' proposals in each placement, and flights in its variations."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np

from cepa import CepaParameters, view
from cepa.scan import Beams
from flights.errors import FlightError
from flights.results.picture_files import svg
from flights.worlds.scenario import THESIS_ALGORITHMS
from master_thesis.experiment_2 import pictures
from master_thesis.experiment_2.let_go import let_go
from master_thesis.experiment_2.proposals import propose, sweep
from master_thesis.experiment_2.trial import TrialParameters
from master_thesis.experiment_2.variations import WORLD, described, fly_variation, variation_parameters
from master_thesis.report.piece import Piece, fingerprint
from master_thesis.report.size import PLACEMENTS_A_PIECE, Size
from simulation_tools.vehicle.uav import load_uav

PATH_STEP = 10
WITH_SWEEP = "columns"
"""The placement whose scan is drawn with several K."""
_UNTIL_FIRST_SCAN = TrialParameters(observe_s=0.2)


def pieces(size: Size) -> list[Piece]:
    """Return the pieces of this size."""
    found = [proposals_piece(scenario) for scenario in size.emergencies]
    firsts = range(1, size.placements + 1, PLACEMENTS_A_PIECE)
    return found + [
        flights_piece(scenario, algorithm, first, min(PLACEMENTS_A_PIECE, size.placements - first + 1))
        for first in firsts
        for scenario in size.emergencies
        for algorithm in THESIS_ALGORITHMS
    ]


def proposals_piece(scenario: str) -> Piece:
    """Return the piece of the placement itself: both algorithms' proposals for the first scan."""
    return Piece(
        name=f"experiment_2_{scenario}_proposals",
        experiment="experiment_2",
        title=f"Experiment 2: {_words(scenario)}, proposals and K",
        run=make_proposals,
        given={"scenario": scenario},
        inputs=_inputs(scenario, "improved", 0),
        cost_s=7.0,
    )


def flights_piece(scenario: str, algorithm: str, first: int, count: int) -> Piece:
    """Return some of the placement's variations, flown by one algorithm."""
    last = first + count - 1
    return Piece(
        name=f"experiment_2_{scenario}_{algorithm}_{first:02d}_to_{last:02d}",
        experiment="experiment_2",
        title=f"Experiment 2: {_words(scenario)}, {algorithm}, placements {first} to {last}",
        run=make_flights,
        given={"scenario": scenario, "algorithm": algorithm, "first": first, "count": count},
        inputs=_inputs(scenario, algorithm, first),
        cost_s=2.5 * count,
    )


def make_proposals(scenario: str) -> dict:
    """Let the UAV go once. Return both algorithms' proposals for the first scan afterwards."""
    parameters = replace(variation_parameters(scenario, "improved", 0), trial=_UNTIL_FIRST_SCAN)
    trial = let_go(parameters)
    if trial.failure is not None:
        raise FlightError(f"{scenario}: {trial.failure}")
    assert trial.first_scan is not None
    description, scan = described(parameters), trial.first_scan.scan
    uav = load_uav(description.model, description.lidar).model
    beams = scan.full_turn(parameters.cepa.dropout_beams)
    swept = sweep(scan, parameters.cepa)
    drawn = {"proposals": svg(pictures.proposals_figure(description, trial, uav))}
    if scenario == WITH_SWEEP:
        drawn["sweep"] = svg(pictures.sweep_figure(description, trial))
    return {
        "proposals": propose(scan, parameters.cepa),
        "sweep": [
            {**asdict(each), "intruding_share": _intruding_share(beams, parameters.cepa, each.k_filter)}
            for each in swept
        ],
        "pictures": drawn,
    }


def _intruding_share(beams: Beams, cepa: CepaParameters, k_filter: float) -> float:
    """Return the share of all directions with an obstacle that is too near after the filter."""
    return len(view.intrusions(beams, replace(cepa, k_filter=k_filter))) / len(beams.ranges)


def make_flights(scenario: str, algorithm: str, first: int, count: int) -> dict:
    """Let the UAV go in each of the variations."""
    flown = (
        fly_variation(variation_parameters(scenario, algorithm, variation))
        for variation in range(first, first + count)
    )
    return {"flights": [replace(f, path_xy=np.round(f.path_xy[::PATH_STEP], 3)) for f in flown]}


def _inputs(scenario: str, algorithm: str, variation: int) -> dict:
    parameters = variation_parameters(scenario, algorithm, variation)
    return fingerprint([parameters, parameters.obstacles], world=WORLD)


def _words(scenario: str) -> str:
    return scenario.replace("_", " ")
