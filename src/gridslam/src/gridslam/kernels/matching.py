"""The pose at which a scan fits a particle's map best: hill climbing, then least squares.

Maps, beams and units are those of `nearest`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gridslam.kernels.least_squares import add_prior, factor, ignore_unobserved, linearise, solve
from gridslam.kernels.nearest import NearestPoints, ParticleMap, find_points, measure, score
from kernel_cache.compiler import njit

CONVERGED_CELLS = 0.03
CONVERGED_RAD = 3e-4
STEPS_HELD = 2
"""Number of Gauss-Newton steps before the nearest points of the map are searched for again."""


class Search(NamedTuple):
    """Settings of a match; lengths in cells, areas in square cells."""

    kernel: int
    score_sigma: float
    refine_sigma: float
    likelihood_sigma: float
    missed: float
    step: float
    turn: float
    halvings: int
    looks: int
    least_score: float


class Motions(NamedTuple):
    """Every particle's pose by odometry; cells and rad."""

    predicted: np.ndarray
    """(particles, 3)"""
    drawn: np.ndarray
    """(particles, 3) with noise."""
    priors: np.ndarray
    """(particles, 3, 3) information of the prediction, in units of one beam's."""


class Matches(NamedTuple):
    """Every particle's pose after matching."""

    poses: np.ndarray
    """(particles, 3) cells and rad: the most likely pose, or the drawn one if the scan does not match."""
    scores: np.ndarray
    """(particles,) best score; the scan matches if it is above minimumScore."""
    log_likelihoods: np.ndarray
    """(particles,) of the scan at the poses."""
    factors: np.ndarray
    """(particles, 3, 3) Cholesky factor of the poses' information, in units of one beam's per cell."""


@njit(cache=True, nogil=True)
def climb(
    start: np.ndarray, beams: np.ndarray, every: int, grid: ParticleMap, search: Search, halvings: int
) -> tuple[float, float, float, float]:
    """Hill climbing over the score: take the best of six steps; halve the steps if none is better.

    Returns the pose (x, y, yaw) and its score; ``start`` is a pose (3,).
    """
    kernel, sigma, step, turn = search.kernel, search.score_sigma, search.step, search.turn
    x, y, yaw = start[0], start[1], start[2]
    best = score(x, y, yaw, beams, every, grid, kernel, sigma, -1.0)
    halved = 0
    while True:
        start_x, start_y, start_yaw, better = x, y, yaw, False
        for move in range(6):
            sign = 1.0 - 2.0 * (move & 1)
            to_x = start_x + (sign * step if move < 2 else 0.0)
            to_y = start_y + (sign * step if 2 <= move < 4 else 0.0)
            to_yaw = start_yaw + (sign * turn if move >= 4 else 0.0)
            value = score(to_x, to_y, to_yaw, beams, every, grid, kernel, sigma, best)
            if value > best:
                best, x, y, yaw, better = value, to_x, to_y, to_yaw, True
        if not better:
            if halved == halvings:
                return x, y, yaw, best
            halved += 1
            step *= 0.5
            turn *= 0.5


@njit(cache=True, nogil=True)
def refine(
    pose: np.ndarray,
    prior_pose: np.ndarray,
    prior: np.ndarray,
    beams: np.ndarray,
    grid: ParticleMap,
    search: Search,
    looks: int,
    nearby: NearestPoints,
    lower: np.ndarray,
) -> int:
    """Move ``pose`` (3,) by Gauss-Newton to the maximum of score and prior.

    The map's nearest points are searched for at most ``looks`` times; ``nearby`` takes the last ones.
    ``prior`` (3, 3) is the information of ``prior_pose``, in units of one beam's. ``lower`` (3, 3) becomes
    the Cholesky factor of the information at the maximum.

    Returns the number of points found.
    """
    information, gradient, start = np.empty((3, 3)), np.empty(3), np.empty(3)
    found = 0
    for _ in range(looks):
        found = find_points(pose[0], pose[1], pose[2], beams, grid, search.kernel, nearby)
        start[:] = pose
        for _ in range(STEPS_HELD):
            information[:] = 0.0
            gradient[:] = 0.0
            sigma = search.refine_sigma
            linearise(pose[0], pose[1], pose[2], beams, nearby, found, sigma, information, gradient)
            ignore_unobserved(information, gradient)
            add_prior(pose, prior_pose, prior, information, gradient)
            factor(information, lower)
            solve(lower, gradient)
            pose += gradient
            if _is_small(gradient):
                break
        if _is_small(pose - start):
            break
    return found


@njit(cache=True, nogil=True, inline="always")
def _is_small(step: np.ndarray) -> bool:
    return abs(step[0]) + abs(step[1]) < CONVERGED_CELLS and abs(step[2]) < CONVERGED_RAD


@njit(cache=True, nogil=True)
def _measure(
    pose: np.ndarray,
    beams: np.ndarray,
    counts: np.ndarray,
    nearby: NearestPoints,
    found: int,
    search: Search,
) -> tuple[float, float]:
    """Return the score and the log-likelihood of a pose (3,) by the points found near it."""
    sigmas = (search.score_sigma, search.likelihood_sigma)
    return measure(
        pose[0], pose[1], pose[2], beams, nearby, found, counts, sigmas[0], sigmas[1], search.missed
    )


@njit(cache=True, nogil=True)
def find_mode(
    candidates: np.ndarray,
    predicted: np.ndarray,
    prior: np.ndarray,
    beams: np.ndarray,
    every: int,
    grid: ParticleMap,
    search: Search,
    looks: int,
    mode: np.ndarray,
    lower: np.ndarray,
) -> float:
    """Climb from every candidate (c, 3) with every ``every``-th beam; refine the best result with all beams.

    ``predicted`` (3,) and ``prior`` (3, 3) belong to the map's particle. ``mode`` (3,) takes the pose,
    and ``lower`` (3, 3) the Cholesky factor of its information. Returns its score.
    """
    top = -1.0
    for c in range(candidates.shape[0]):
        x, y, yaw, value = climb(candidates[c], beams, every, grid, search, 1)
        if value > top:
            top = value
            mode[0], mode[1], mode[2] = x, y, yaw
    nearby = _room_for(beams)
    found = refine(mode, predicted, prior, beams, grid, search, looks, nearby, lower)
    return _measure(mode, beams, np.ones(beams.shape[0], np.bool_), nearby, found, search)[0]


@njit(cache=True, nogil=True, inline="always")
def _room_for(beams: np.ndarray) -> NearestPoints:
    return NearestPoints(np.empty((beams.shape[0], 2)), np.empty(beams.shape[0], np.int64))


@njit(cache=True, nogil=True)
def match(
    first: int,
    last: int,
    starts: np.ndarray,
    motions: Motions,
    expected: float,
    is_ambiguous: bool,
    beams: np.ndarray,
    counts: np.ndarray,
    search: Search,
    tables: np.ndarray,
    surfaces: tuple[np.ndarray, np.ndarray, np.ndarray],
    matches: Matches,
) -> None:
    """Match the scan of particles first to last - 1 against their own maps, and write the ``matches``.

    Each particle is refined from its start. If its score stays below ``expected``, it also climbs from its
    drawn pose, and keeps the better result. If the scan is ambiguous, it only climbs from its drawn pose. A
    particle whose score does not exceed the search's least is not matched: it stays at its drawn pose, and
    the scan's likelihood is that of this pose. ``counts`` (n,) bool names the beams that count in
    likelihoods. ``surfaces`` are the tiles' occupied, ends and means.
    """
    scores, likelihoods, factors = matches.scores, matches.log_likelihoods, matches.factors
    lower, looks = np.zeros((3, 3)), search.looks
    nearby = _room_for(beams)
    for p in range(first, last):
        grid, pose = ParticleMap(tables[p], surfaces[0], surfaces[1], surfaces[2]), matches.poses[p]
        predicted, prior = motions.predicted[p], motions.priors[p]
        pose[:] = starts[p]
        scores[p] = -1.0
        if not is_ambiguous:
            found = refine(pose, predicted, prior, beams, grid, search, looks, nearby, factors[p])
            scores[p], likelihoods[p] = _measure(pose, beams, counts, nearby, found, search)
        if is_ambiguous or scores[p] < expected:
            x, y, yaw, _ = climb(motions.drawn[p], beams, 1, grid, search, search.halvings)
            other = np.array((x, y, yaw))
            found = refine(other, predicted, prior, beams, grid, search, looks, nearby, lower)
            value, likelihood = _measure(other, beams, counts, nearby, found, search)
            if value > scores[p]:
                scores[p], likelihoods[p] = value, likelihood
                pose[:] = other
                factors[p] = lower
        if not scores[p] > search.least_score:
            pose[:] = motions.drawn[p]
            found = find_points(pose[0], pose[1], pose[2], beams, grid, search.kernel, nearby)
            likelihoods[p] = _measure(pose, beams, counts, nearby, found, search)[1]
