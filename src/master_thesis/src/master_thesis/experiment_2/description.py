"""What was run in a trial of Experiment 2, and its flight as seen from where the UAV hovered."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from cepa import CepaParameters
from master_thesis.experiment_2.trial import EmergencyTrial
from master_thesis.worlds.placements import freeze_frame


@dataclass(frozen=True)
class TrialDescription:
    """What was run. cepa: its parameters; parameters: every node's, by node name (empty without ROS)."""

    scenario: str
    algorithm: str
    lidar: str
    seed: int
    world: Path
    cepa: CepaParameters
    model: str = "iris"
    parameters: dict[str, dict] = field(default_factory=dict)
    experiment: str = "experiment_2"


def flown(trial: EmergencyTrial) -> np.ndarray:
    """Return the true poses (n, 8: t, position, quaternion) in `world` from letting go on."""
    if trial.freeze is None:
        return np.empty((0, 8))
    return trial.log.between(trial.freeze.t_s, np.inf)


def in_freeze_frame(trial: EmergencyTrial, positions_xyz: np.ndarray) -> np.ndarray:
    """Return positions (n, 3) of `world` in the frame of the placement: from where the UAV hovered."""
    return freeze_frame(trial.freeze.uav).inverse().transform(positions_xyz)
