"""The description of a trial of Experiment 2, and its flight in the frame of the placement."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from cepa import CepaParameters
from flights.errors import FlightError
from flights.worlds.placements import freeze_frame
from master_thesis.experiment_2.trial import EmergencyTrial, FirstScan, Freeze


@dataclass(frozen=True)
class TrialDescription:
    """The description of a trial.

    cepa: CEPA's parameters; parameters: all nodes', by node (empty without ROS).
    """

    scenario: str
    algorithm: str
    lidar: str
    seed: int
    world: Path
    cepa: CepaParameters
    model: str = "iris"
    parameters: dict[str, dict] = field(default_factory=dict)
    experiment: str = "experiment_2"


def freeze_of(trial: EmergencyTrial) -> Freeze:
    """Return the freeze; raises FlightError if time was never stopped."""
    if trial.freeze is None:
        raise FlightError("No obstacles were placed in this trial.")
    return trial.freeze


def first_scan_of(trial: EmergencyTrial) -> FirstScan:
    """Return the first scan of the obstacles; raises FlightError if there is none."""
    if trial.first_scan is None:
        raise FlightError("No scan shows the obstacles of this trial.")
    return trial.first_scan


def flown(trial: EmergencyTrial) -> np.ndarray:
    """Return the true poses (n, 8: t, position, quaternion) in `world`, from the release on."""
    if trial.freeze is None:
        return np.empty((0, 8))
    return trial.log.between(trial.freeze.t_s, np.inf)


def in_freeze_frame(trial: EmergencyTrial, positions_xyz: np.ndarray) -> np.ndarray:
    """Return positions (n, 3) of `world` in the frame of the placement."""
    return freeze_frame(freeze_of(trial).uav).inverse().transform(positions_xyz)
