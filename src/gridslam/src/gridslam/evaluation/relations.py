"""Errors of a trajectory by hand-verified relative poses.

R. Kuemmerle et al., "On measuring the accuracy of SLAM algorithms", Autonomous Robots 27 (2009). A human has
verified the relative pose of two moments. The error is the difference of the estimated relative pose from
it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gridslam import se2
from gridslam.errors import EvaluationError
from gridslam.files.number_rows import read_rows
from gridslam.files.tum import poses_at
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

    def within(self, first_s: float, last_s: float) -> Relations:
        """Return those of which both moments lie in a span of time (within 1 ms)."""
        chosen = (
            (self.stamps_s >= first_s - EXACT_WITHIN_S) & (self.stamps_s <= last_s + EXACT_WITHIN_S)
        ).all(axis=1)
        return Relations(self.stamps_s[chosen], self.second_in_first[chosen])


@dataclass(frozen=True)
class RelationErrors:
    """Mean and standard deviation of the errors over the relations, and of their squares."""

    relations: int
    """Number of relations that were compared."""
    relations_outside: int
    """Number of relations left out, because one of their moments is outside the trajectory's time."""
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
    rows = read_rows(path, "8 finite numbers: t1 t2 x y z roll pitch yaw", columns=(8,))
    return Relations(rows[:, :2], rows[:, (2, 3, 7)])


def relation_errors(trajectory: Trajectory, relations: Relations) -> RelationErrors:
    """Compare a trajectory, interpolated at the moments, with the relations in its time.

    Raises:
        EvaluationError: there is no relation to compare with.
    """
    if not len(relations):
        raise EvaluationError("There is no relation to judge the trajectory by.")
    begin_s, end_s = trajectory.stamps_s[0], trajectory.stamps_s[-1]
    inside = relations.within(begin_s, end_s)
    if not len(inside):
        raise EvaluationError(
            f"None of the {len(relations)} relations lies in the trajectory's time, {begin_s:.3f} to "
            f"{end_s:.3f} s; theirs is {relations.stamps_s.min():.3f} to {relations.stamps_s.max():.3f} s."
        )
    first, second = (poses_at(trajectory, stamps) for stamps in inside.stamps_s.T)
    difference = se2.between(inside.second_in_first, se2.between(first, second))
    metres = np.hypot(difference[:, 0], difference[:, 1])
    degrees = np.degrees(np.abs(se2.wrap(difference[:, 2])))
    figures = (
        float(f(values)) for values in (metres, metres**2, degrees, degrees**2) for f in (np.mean, np.std)
    )
    return RelationErrors(len(inside), len(relations) - len(inside), *figures)
