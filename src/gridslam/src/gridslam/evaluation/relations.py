"""Errors of a trajectory by hand-verified relative poses.

R. Kuemmerle et al., "On measuring the accuracy of SLAM algorithms", Autonomous Robots 27 (2009): what counts
is the difference between the relative pose of two moments as estimated and as verified by a human.
"""

from __future__ import annotations

import gzip
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gridslam import se2
from gridslam.errors import EvaluationError
from gridslam.evaluation.tum import poses_at
from gridslam.trajectory import Trajectory

EXACT_WITHIN_S = 0.001


@dataclass(frozen=True)
class Relations:
    """True relative poses: stamps_s (n, 2) of both moments, second_in_first (n, 3): x m, y m, yaw rad."""

    stamps_s: np.ndarray
    second_in_first: np.ndarray

    def __len__(self) -> int:
        return len(self.stamps_s)

    def exact(self, scan_stamps_s: np.ndarray) -> Relations:
        """Return those of which both moments are within 1 ms of a scan's stamp (sorted, (k,))."""
        after = np.clip(np.searchsorted(scan_stamps_s, self.stamps_s), 1, len(scan_stamps_s) - 1)
        gap_s = np.minimum(
            np.abs(scan_stamps_s[after] - self.stamps_s), np.abs(scan_stamps_s[after - 1] - self.stamps_s)
        )
        chosen = (gap_s <= EXACT_WITHIN_S).all(axis=1)
        return Relations(self.stamps_s[chosen], self.second_in_first[chosen])


@dataclass(frozen=True)
class RelationErrors:
    """Mean and standard deviation of the errors over the relations, and of their squares."""

    relations: int
    translation_mean_m: float
    translation_std_m: float
    translation_squared_mean_m2: float
    translation_squared_std_m2: float
    rotation_mean_deg: float
    rotation_std_deg: float
    rotation_squared_mean_deg2: float
    rotation_squared_std_deg2: float


def read_relations(path: Path) -> Relations:
    """Read a relations file, gzipped or not: ``t1 t2 x y z roll pitch yaw`` a line.

    Raises:
        EvaluationError: the file cannot be read or is in another form.
    """
    try:
        with (gzip.open if str(path).endswith(".gz") else open)(path, "rt") as file:
            rows = np.loadtxt(file, ndmin=2)
    except (OSError, EOFError, ValueError) as error:
        raise EvaluationError(f"{path}: cannot be read as relations ({error}).") from None
    if rows.shape[1] != 8 or not len(rows):
        raise EvaluationError(f"{path}: each line must hold 8 numbers: t1 t2 x y z roll pitch yaw.")
    return Relations(rows[:, :2], rows[:, (2, 3, 7)])


def relation_errors(trajectory: Trajectory, relations: Relations) -> RelationErrors:
    """Judge a trajectory, interpolated at the relations' moments.

    Raises:
        EvaluationError: there is no relation to judge it by.
    """
    if not len(relations):
        raise EvaluationError("No relation has both stamps within 1 ms of a scan: nothing to judge by.")
    first, second = (poses_at(trajectory, stamps) for stamps in relations.stamps_s.T)
    difference = se2.between(relations.second_in_first, se2.between(first, second))
    metres = np.hypot(difference[:, 0], difference[:, 1])
    degrees = np.degrees(np.abs(se2.wrap(difference[:, 2])))
    figures = (
        float(f(values)) for values in (metres, metres**2, degrees, degrees**2) for f in (np.mean, np.std)
    )
    return RelationErrors(len(relations), *figures)
