"""How large the path's errors are, as a share of what its covariances tell: closures and links measure it.

The covariances assume few independent points in a match, and odometry as it is configured. In bare walls
seen far away the errors are much smaller, after poor scans they may be larger. So the path's covariance is
scaled as in the adjustment of surveys, by its a posteriori variance of unit weight: the mean of the squared
errors, each divided by its variance (K.-R. Koch, "Parameter Estimation and Hypothesis Testing in Linear
Models", 1999).
"""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.loop_closure.consistent_set import UncorrectedPath
from gridslam.loop_closure.edges import Edges, Match
from gridslam.loop_closure.path.measured_path import MeasuredPath
from gridslam.loop_closure.path.step_uncertainty import CHI_SQUARE_75, STEPS_MIN


def error_share(
    path: MeasuredPath,
    step_covariances: np.ndarray,
    links: Edges,
    closures: Sequence[Match],
    support_m: float,
) -> float:
    """Return the errors' standard deviation as a share of that which the covariances tell.

    Links of a scan with the one before it give a first value, at most 1. It counts as much as one closure.
    Closures that are near each other on the path tell the same error, so each counts by its distance from the
    one before it.

    Args:
        path: k nodes.
        step_covariances: (k - 1, 3, 3) of its steps.
        links: between scans; only those of neighbours count.
        closures: those that count, in any order.
        support_m: closures that are farther apart count wholly, m.
    """
    first = min(1.0, _of_links(path, step_covariances, links))
    if not closures:
        return math.sqrt(first)
    found = Edges.of(sorted(closures, key=lambda closure: closure.newer))
    straight = UncorrectedPath(path, step_covariances, np.zeros(len(step_covariances)))
    by_steps = se2.between(straight.poses[found.older], straight.poses[found.newer])
    covariances = straight.covariances(found.newer, found.older) + found.covariance
    squares = _chi_squares(se2.between(found.newer_in_older, by_steps), covariances) / 3.0
    gaps_m = np.diff(path.way_m[found.newer], prepend=-math.inf)
    weights = np.minimum(1.0, gaps_m / support_m)
    return math.sqrt((first + float(weights @ squares)) / (1.0 + float(weights.sum())))


def _of_links(path: MeasuredPath, step_covariances: np.ndarray, links: Edges) -> float:
    """Return the square of the share, by the filter's steps and links; 1: too few. Few may err wholly."""
    is_own = links.newer - links.older == 1
    if is_own.sum() < STEPS_MIN:
        return 1.0
    steps = links.older[is_own]
    error = se2.between(links.newer_in_older[is_own], path.steps[steps])
    squares = _chi_squares(error, step_covariances[steps] + links.covariance[is_own])
    return float(np.quantile(squares, 0.75) / CHI_SQUARE_75)


def _chi_squares(errors: np.ndarray, covariances: np.ndarray) -> np.ndarray:
    return np.einsum("ni,ni->n", errors, np.linalg.solve(covariances, errors[:, :, None])[:, :, 0])
