"""How large the path's errors are, as a share of what its covariances tell: closures and links measure it.

The covariances assume few independent points in a match, and odometry as it is configured. In bare walls
seen far away the errors are much smaller, after poor scans they may be larger. So the path's covariance is
scaled as in the adjustment of surveys, by its a posteriori variance of unit weight (K.-R. Koch, "Parameter
Estimation and Hypothesis Testing in Linear Models", 1999). Here it has two components: what scans have
measured, and what they have left to odometry, as along a bare corridor.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from gridslam import se2
from gridslam.loop_closure.consistent_set import UncorrectedPath
from gridslam.loop_closure.edges import Edges, Match
from gridslam.loop_closure.path.measured_path import MeasuredPath
from gridslam.loop_closure.path.step_uncertainty import CHI_SQUARE_75, STEPS_MIN

SQUARE_MIN = 1e-4
"""Least square of a share: no measurement is exact."""


class ErrorShares(NamedTuple):
    """Standard deviations of errors, as shares of what covariances tell."""

    scans: float = 1.0
    """Where scans have measured a step."""
    odometry: float = 1.0
    """Where they have not, so that odometry alone tells it."""


def error_shares(
    path: MeasuredPath,
    step_covariances: np.ndarray,
    links: Edges,
    closures: Sequence[Match],
    support_m: float,
    spread_m2: float,
) -> ErrorShares:
    """Return the shares for a pose of a variance of ``spread_m2``, of x and y together.

    Each loop counts by the variance of its place before it was closed. So a short one, whose errors are
    small in any case, tells little of long ways. Links of a scan with the one before it give a first value
    for scans, at most 1; for odometry it is 1. It counts like one loop of the pose's own variance.
    Closures that are near each other on the path tell the same error, so each counts by its distance from the
    one before it.

    Args:
        path: k nodes.
        step_covariances: (k - 1, 3, 3) of its steps.
        links: between scans; only those of neighbours count.
        closures: those that count, in any order.
        support_m: closures that are farther apart count wholly, m.
        spread_m2: see above, m2.
    """
    first = min(1.0, _of_links(path, step_covariances, links))
    squares_m2 = variances_m2 = 0.0
    if closures:
        found = Edges.of(sorted(closures, key=lambda closure: closure.newer))
        straight = UncorrectedPath(path, step_covariances, np.zeros(len(step_covariances)))
        by_steps = se2.between(straight.poses[found.older], straight.poses[found.newer])
        covariances = straight.covariances(found.newer, found.older) + found.covariance
        errors = se2.between(found.newer_in_older, by_steps)
        weights = np.minimum(1.0, np.diff(path.way_m[found.newer], prepend=-math.inf) / support_m)
        squares_m2 = float(weights @ (errors[:, :2] ** 2).sum(axis=1))
        variances_m2 = float(weights @ (covariances[:, 0, 0] + covariances[:, 1, 1]))
    told_m2 = max(spread_m2 + variances_m2, 1e-12)
    squares = ((value * spread_m2 + squares_m2) / told_m2 for value in (first, 1.0))
    return ErrorShares(*(math.sqrt(max(SQUARE_MIN, square)) for square in squares))


def scaled(covariances: np.ndarray, by_odometry: np.ndarray, shares: ErrorShares) -> np.ndarray:
    """Return covariances (n, 3, 3) of steps with the errors' usual size.

    ``by_odometry`` (n, 3, 3), diagonal, are those of odometry alone. In each direction a part of its variance
    is left, because scans have measured the rest. The larger it is, the more it errs as odometry does.
    """
    sigmas = np.sqrt(np.diagonal(by_odometry, axis1=1, axis2=2))
    units = sigmas[:, :, None] * sigmas[:, None, :]
    left, directions = np.linalg.eigh(covariances / units)
    part = np.clip(left, 0.0, 1.0)
    left = left * ((1.0 - part) * shares.scans**2 + part * shares.odometry**2)
    return (directions * left[:, None, :]) @ directions.transpose(0, 2, 1) * units


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
