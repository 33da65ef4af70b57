"""Results of loop closure: matches are candidates, closures count."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Match:
    """A place found again: nodes, relative pose (3,), and its covariance (3, 3) in the newer's frame."""

    older: int
    newer: int
    newer_in_older: np.ndarray
    covariance: np.ndarray
    score: float


@dataclass(frozen=True)
class Closure:
    """A closed loop: both moments, the later pose (x m, y m, yaw rad) seen from the earlier, the score."""

    stamp_from_s: float
    stamp_to_s: float
    pose_difference: tuple[float, float, float]
    score: float
