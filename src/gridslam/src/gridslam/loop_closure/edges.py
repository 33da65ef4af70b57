"""Edges of the pose graph: measured poses of one node in another.

A `Match` is a candidate that has passed all tests. The matches of the consistent set are the closures: inside
the back end they stay `Match`, and `Closure` is how one is reported, by its stamps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Sequence

import numpy as np


@dataclass(frozen=True, eq=False)
class Edge:
    """A measurement: the pose (3,) of the newer node in the older, with its covariance (3, 3)."""

    older: int
    newer: int
    newer_in_older: np.ndarray
    covariance: np.ndarray


@dataclass(frozen=True, eq=False)
class Match(Edge):
    """A place found again (stage 3). Its covariance is in the newer node's frame."""

    score: float
    climb_m: float = math.nan
    """How much higher the newer node is; NaN: not measured."""
    climb_sigma_m: float = math.nan
    """Standard deviation of this."""


@dataclass(frozen=True)
class Closure:
    """The report of a closure: both moments, the later pose (x m, y m, yaw rad) in the earlier, the score."""

    stamp_from_s: float
    stamp_to_s: float
    pose_difference: tuple[float, float, float]
    score: float


class Edges(NamedTuple):
    """Edges as arrays: nodes (m,), poses (m, 3), covariances (m, 3, 3)."""

    older: np.ndarray
    newer: np.ndarray
    newer_in_older: np.ndarray
    covariance: np.ndarray

    @classmethod
    def of(cls, edges: Sequence[Edge]) -> Edges:
        """Return them as arrays."""
        return cls(
            np.array([edge.older for edge in edges], int),
            np.array([edge.newer for edge in edges], int),
            np.array([edge.newer_in_older for edge in edges]).reshape(-1, 3),
            np.array([edge.covariance for edge in edges]).reshape(-1, 3, 3),
        )

    def each(self) -> list[Edge]:
        """Return them one by one."""
        rows = zip(self.older.tolist(), self.newer.tolist(), self.newer_in_older, self.covariance)
        return [Edge(*row) for row in rows]

    @classmethod
    def joined(cls, parts: Sequence[Edges]) -> Edges:
        """Return the edges of all parts, one after the other."""
        return cls(*(np.concatenate(arrays) for arrays in zip(*parts)))
