"""Stage 4, the consistent set: of all matches, the largest set that agrees pairwise. These are the closures.

J. G. Mangelson et al., "Pairwise consistent measurement set maximization for robust multi-robot map merging"
(ICRA 2018). Two matches and the path between their ends form a loop. It must close within its uncertainty.
A closure needs another one near it on the path, so a single match never moves the map.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.loop_closure.edges import Match
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.measured_path import MeasuredPath, chained
from gridslam.loop_closure.path.way_uncertainty import carried

HEIGHT_CHI_SQUARE_MAX = 6.63
"""99 % of a distribution with one degree of freedom."""


@dataclass(frozen=True, eq=False)
class MatchSet:
    """All matches so far, and which of them agree with each other.

    Raises:
        ValueError: the table is not of the matches.
    """

    matches: tuple[Match, ...] = ()
    agree: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), dtype=bool))
    """(n, n) symmetric."""

    def __post_init__(self) -> None:
        if self.agree.shape != (len(self.matches),) * 2 or self.agree.dtype != bool:
            raise ValueError("the table of matches that agree is not of these matches")

    def with_match(self, match: Match, path: UncorrectedPath, parameters: LoopClosureParameters) -> MatchSet:
        """Return the set with one more."""
        agrees = contradictions(path, match, self.matches) <= parameters.chi_square_max
        agrees &= ~contradict_in_height(path, match, self.matches)
        count = len(self.matches)
        agree = np.ones((count + 1, count + 1), dtype=bool)
        agree[:count, :count] = self.agree
        agree[count, :count] = agree[:count, count] = agrees
        return MatchSet((*self.matches, match), agree)

    def closures(self, way_m: np.ndarray, parameters: LoopClosureParameters) -> tuple[int, ...]:
        """Return the indices of the matches that count, for the length of way (k,) up to each node."""
        chosen = largest_consistent(self.agree)
        return tuple(supported(self.matches, chosen, way_m, parameters.support_m))


class UncorrectedPath:
    """The path of the measured steps without corrections, and its growing uncertainty.

    step_covariances: (k - 1, 3, 3). climb_variances_m2: (k - 1,) of the steps' climbs.
    """

    def __init__(
        self, path: MeasuredPath, step_covariances: np.ndarray, climb_variances_m2: np.ndarray
    ) -> None:
        self.poses = chained(path.poses[0], path.steps)
        self.heights_m = np.concatenate([[0.0], np.cumsum(path.climbs_m)])
        self._climbs_summed = np.concatenate([[0.0], np.cumsum(climb_variances_m2)])
        in_map = carried(step_covariances, self.poses[1:])
        self._summed = np.concatenate([np.zeros((1, 3, 3)), np.cumsum(in_map, axis=0)])

    def covariances(self, node: int | np.ndarray, others: np.ndarray) -> np.ndarray:
        """Return the covariances (n, 3, 3) of the path from a node to others (n,), in the node's frame.

        node: may be one for each of the others (n,).
        """
        between = self._summed[np.maximum(node, others)] - self._summed[np.minimum(node, others)]
        return carried(between, se2.inverse(self.poses[node]).reshape(-1, 3))

    def height_variance_m2(self, node: int, others: np.ndarray) -> np.ndarray:
        """Return the variances (n,) of the climbs along the path from a node to others (n,), m2."""
        return np.abs(self._climbs_summed[others] - self._climbs_summed[node])


def contradictions(path: UncorrectedPath, first: Match, others: Sequence[Match]) -> np.ndarray:
    """Return the chi-square (n,) of a match's loop with each of the others.

    first.newer -> first.older (match) -> other.older (path) -> other.newer (match) -> first.newer (path)
    """
    older, newer = (
        np.array([getattr(match, end) for match in others], dtype=int) for end in ("older", "newer")
    )
    poses = np.reshape([match.newer_in_older for match in others], (-1, 3))
    covariances = np.reshape([match.covariance for match in others], (-1, 3, 3))
    back = se2.inverse(first.newer_in_older)
    other_older = se2.compose(back, se2.between(path.poses[first.older], path.poses[older]))
    other_newer = se2.compose(other_older, poses)
    error = se2.compose(other_newer, se2.between(path.poses[newer], path.poses[first.newer]))
    covariance = (
        first.covariance
        + carried(covariances, other_newer)
        + path.covariances(first.newer, newer)
        + carried(path.covariances(first.older, older), back[None])
    )
    return np.einsum("ni,ni->n", error, np.linalg.solve(covariance, error[:, :, None])[:, :, 0])


def contradict_in_height(path: UncorrectedPath, first: Match, others: Sequence[Match]) -> np.ndarray:
    """Return with which of the others (n,) a match makes a loop that does not close in height.

    A climb that was not measured contradicts none.
    """
    older, newer = (
        np.array([getattr(match, end) for match in others], dtype=int) for end in ("older", "newer")
    )
    climbs_m = np.array([match.climb_m for match in others], float)
    sigmas_m = np.array([match.climb_sigma_m for match in others], float)
    heights_m = path.heights_m
    climb_m = first.climb_m - (heights_m[first.newer] - heights_m[first.older])
    error_m = climb_m - (climbs_m - (heights_m[newer] - heights_m[older]))
    variance_m2 = (
        first.climb_sigma_m**2
        + sigmas_m**2
        + path.height_variance_m2(first.older, older)
        + path.height_variance_m2(first.newer, newer)
    )
    return error_m**2 > HEIGHT_CHI_SQUARE_MAX * variance_m2  # NaN is not


def largest_consistent(agree: np.ndarray) -> list[int]:
    """Return the indices of the largest set whose members all agree.

    agree: symmetric (n, n) bool. This is the greedy search of Pattabiraman et al. (2015) for large
    cliques, from every member that could give a larger one.
    """
    count = len(agree)
    linked = agree & ~np.eye(count, dtype=bool)
    degree = linked.sum(axis=1)
    best: list[int] = []
    for start in np.argsort(-degree, kind="stable"):
        if degree[start] + 1 <= len(best):
            break
        clique, possible = [int(start)], linked[start].copy()
        while possible.any():
            chosen = int(np.argmax(np.where(possible, degree, -1)))
            clique.append(chosen)
            possible &= linked[chosen]
        if len(clique) > len(best):
            best = clique
    return sorted(best)


def supported(
    matches: Sequence[Match], chosen: Sequence[int], way_m: np.ndarray, within_m: float
) -> list[int]:
    """Return the chosen matches with another one whose newer node is near along the path."""
    ways = np.array([way_m[matches[i].newer] for i in chosen])
    newer = np.array([matches[i].newer for i in chosen])
    kept = []
    for i, way, node in zip(chosen, ways, newer):
        if ((np.abs(ways - way) <= within_m) & (newer != node)).any():
            kept.append(i)
    return kept
