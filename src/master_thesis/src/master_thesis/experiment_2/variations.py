"""Variations of Experiment 2: each placement with slightly shifted obstacles, flown by both algorithms."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Mapping, Sequence

import numpy as np

from cepa import CepaParameters
from flights.errors import FlightError
from flights.worlds.placements import R_LB_M
from flights.worlds.scenario import WORLDS
from master_thesis.experiment_2.description import TrialDescription, flown, in_freeze_frame
from master_thesis.experiment_2.let_go import LetGoParameters, let_go
from master_thesis.experiment_2.metrics import clearances, proposals_of, trial_metrics
from master_thesis.experiment_2.trial import EmergencyTrial

WORLD = WORLDS / "empty.world"
REFUSED = "emergency open section"
"""The improved algorithm's reason if the original proposal leads into an obstacle or is zero."""


@dataclass(frozen=True)
class Flown:
    """The result of one flight.

    proposal_refused: whether the improved algorithm's proposal for the first scan differs from the
    original's. path_xy: (n, 2) in the frame of the placement. touch_xy: (2,) the UAV's place at its first
    contact.
    """

    scenario: str
    algorithm: str
    metrics: dict
    proposal_refused: bool
    path_xy: np.ndarray
    touch_xy: np.ndarray | None

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> Flown:
        """Return a flight from its JSON form."""
        path_xy, touch_xy = np.array(plain["path_xy"]).reshape(-1, 2), plain["touch_xy"]
        touched = None if touch_xy is None else np.array(touch_xy)
        return cls(**{**plain, "path_xy": path_xy, "touch_xy": touched})


def variation_parameters(
    scenario: str, algorithm: str, variation: int, k_filter: float = 50.0
) -> LetGoParameters:
    """Return a trial. Both algorithms get the same placements and the same noise. k_filter: m/rad."""
    parameters = CepaParameters(r_lb=R_LB_M, k_filter=k_filter)
    return LetGoParameters(str(WORLD), scenario, algorithm, variation, seed=variation or 1, cepa=parameters)


def described(parameters: LetGoParameters) -> TrialDescription:
    """Return the description of a trial for pictures and summary."""
    return TrialDescription(
        parameters.scenario,
        parameters.algorithm,
        parameters.lidar,
        parameters.seed,
        Path(parameters.world),
        parameters.cepa,
    )


def fly_variation(parameters: LetGoParameters) -> Flown:
    """Fly one trial and measure it.

    Raises:
        FlightError: it was not flown to its end.
    """
    trial = let_go(parameters)
    if trial.failure is not None:
        raise FlightError(f"{parameters.scenario}, variation {parameters.variation}: {trial.failure}")
    description = described(parameters)
    metrics = trial_metrics(trial, clearances(description, trial))
    poses = flown(trial)
    path_xy = in_freeze_frame(trial, poses[:, 1:4])[:, :2]
    proposed = proposals_of(description, trial)[0]
    return Flown(
        parameters.scenario,
        parameters.algorithm,
        metrics,
        proposed.reason == REFUSED,
        path_xy,
        _first_touch(trial, poses[:, 0], path_xy),
    )


def _first_touch(trial: EmergencyTrial, times_s: np.ndarray, path_xy: np.ndarray) -> np.ndarray | None:
    """Return the place on the path (n, 2) of the first contact."""
    if not trial.touched:
        return None
    index = int(np.searchsorted(times_s, min(trial.touched.values())))
    return path_xy[min(index, len(path_xy) - 1)]


def variations_metrics(flights: Sequence[Flown]) -> dict:
    """Return the metrics over the flights of one scenario and algorithm."""
    clearances_m = [flight.metrics["min_clearance_m"] for flight in flights]
    left_s = [flight.metrics["left_after_s"] for flight in flights if flight.metrics["left"]]
    return {
        "flights": len(flights),
        "touched": sum(flight.metrics["collision"] for flight in flights),
        "left": len(left_s),
        "left_after_s": float(np.median(left_s)) if left_s else None,
        "min_clearance_m": min(clearances_m),
        "median_clearance_m": float(np.median(clearances_m)),
        "original_proposal_refused": sum(flight.proposal_refused for flight in flights),
    }
