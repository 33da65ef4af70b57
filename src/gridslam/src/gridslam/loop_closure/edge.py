"""An edge of the pose graph."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Edge:
    """A measurement: the pose (3,) of the newer node in the older, with its covariance (3, 3)."""

    older: int
    newer: int
    newer_in_older: np.ndarray
    covariance: np.ndarray
