"""The pose at which a scan fits a particle's map best: hill climbing, then least squares.

Maps, beams and units are those of `nearest`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from gridslam.kernels.least_squares import add_prior, factor, linearise, solve
from gridslam.kernels.nearest import find_points, measure, score

CONVERGED_CELLS = 0.03
CONVERGED_RAD = 3e-4
STEPS_HELD = 2
"""Gauss-Newton's steps towards the same points of the map, before the nearest ones are looked for again."""


@njit(cache=True, nogil=True)
def climb(x, y, yaw, beams, every, table, occupied, ends, means, kernel, sigma, step, turn, halvings):
    """Hill climbing over the score: the best of six steps, and halved steps where none is better."""
    best = score(x, y, yaw, beams, every, table, occupied, ends, means, kernel, sigma, -1.0)
    halved = 0
    while True:
        start_x, start_y, start_yaw, better = x, y, yaw, False
        for move in range(6):
            sign = 1.0 - 2.0 * (move & 1)
            to_x = start_x + (sign * step if move < 2 else 0.0)
            to_y = start_y + (sign * step if 2 <= move < 4 else 0.0)
            to_yaw = start_yaw + (sign * turn if move >= 4 else 0.0)
            value = score(to_x, to_y, to_yaw, beams, every, table, occupied, ends, means, kernel, sigma, best)
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
    pose,
    prior_pose,
    prior,
    beams,
    table,
    occupied,
    ends,
    means,
    kernel,
    sigma,
    looks,
    points,
    which,
    lower,
):
    """Move ``pose`` (3,) by Gauss-Newton to the maximum of score and prior.

    The map's nearest points are looked for at most ``looks`` times; ``points`` (n, 2) and ``which`` (n,) take
    those found last, see `find_points`. ``prior`` (3, 3) is the information of ``prior_pose``, in units of
    one beam's. ``lower`` (3, 3) becomes the Cholesky factor of the information at the maximum.

    Returns how many points were found.
    """
    information, gradient, start = np.empty((3, 3)), np.empty(3), np.empty(3)
    found = 0
    for _ in range(looks):
        found = find_points(
            pose[0], pose[1], pose[2], beams, table, occupied, ends, means, kernel, points, which
        )
        start[:] = pose
        for _ in range(STEPS_HELD):
            information[:] = 0.0
            gradient[:] = 0.0
            linearise(pose[0], pose[1], pose[2], beams, points, which, found, sigma, information, gradient)
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
def _is_small(step):
    return abs(step[0]) + abs(step[1]) < CONVERGED_CELLS and abs(step[2]) < CONVERGED_RAD


class Search(NamedTuple):
    """What a match is made with; lengths in cells, areas in square cells."""

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


@njit(cache=True, nogil=True)
def _refine_and_measure(
    pose, predicted, prior, beams, table, occupied, ends, means, search, looks, points, which, lower
):
    """Move a pose to the maximum that Gauss-Newton finds from it; return its score and log-likelihood."""
    found = refine(
        pose,
        predicted,
        prior,
        beams,
        table,
        occupied,
        ends,
        means,
        search.kernel,
        search.refine_sigma,
        looks,
        points,
        which,
        lower,
    )
    sigmas = (search.score_sigma, search.likelihood_sigma)
    return measure(
        pose[0], pose[1], pose[2], beams, points, which, found, sigmas[0], sigmas[1], search.missed
    )


@njit(cache=True, nogil=True)
def _likelihood_at(pose, beams, table, occupied, ends, means, search, points, which):
    """Return the scan's log-likelihood at a pose (3,)."""
    x, y, yaw = pose
    found = find_points(x, y, yaw, beams, table, occupied, ends, means, search.kernel, points, which)
    sigmas = (search.score_sigma, search.likelihood_sigma)
    return measure(x, y, yaw, beams, points, which, found, sigmas[0], sigmas[1], search.missed)[1]


@njit(cache=True, nogil=True)
def find_mode(candidates, predicted, prior, beams, every, search, looks, table, occupied, ends, means, mode):
    """Climb from every candidate (c, 3) with every ``every``-th beam, and refine the best end with all.

    ``predicted`` (3,) and ``prior`` (3, 3) are those of the particle whose map it is; ``mode`` (3,) takes the
    pose. Returns its score.
    """
    top = -1.0
    for c in range(candidates.shape[0]):
        x, y, yaw, value = climb(
            candidates[c, 0],
            candidates[c, 1],
            candidates[c, 2],
            beams,
            every,
            table,
            occupied,
            ends,
            means,
            search.kernel,
            search.score_sigma,
            search.step,
            search.turn,
            1,
        )
        if value > top:
            top = value
            mode[0], mode[1], mode[2] = x, y, yaw
    points, which = np.empty((beams.shape[0], 2)), np.empty(beams.shape[0], np.int64)
    lower = np.zeros((3, 3))
    return _refine_and_measure(
        mode, predicted, prior, beams, table, occupied, ends, means, search, looks, points, which, lower
    )[0]


@njit(cache=True, nogil=True)
def match(
    first,
    last,
    starts,
    drawn,
    predicted,
    priors,
    expected,
    is_ambiguous,
    beams,
    search,
    tables,
    occupied,
    ends,
    means,
    poses,
    scores,
    likelihoods,
    factors,
):
    """Match the scan of particles first to last - 1 against their own maps.

    Each is refined from its start; one that stays below the ``expected`` score climbs from where its motion
    was drawn, and keeps the better end. Where the scan is ambiguous each keeps what it reached from its own
    draw. One whose score does not exceed the search's least is not matched: it stays where it was drawn, and
    the scan's likelihood is judged there. ``poses``, ``scores``, ``likelihoods`` (log) and ``factors``
    (Cholesky, of the information) take the results.
    """
    lower = np.zeros((3, 3))
    points, which = np.empty((beams.shape[0], 2)), np.empty(beams.shape[0], np.int64)
    for p in range(first, last):
        table, pose = tables[p], poses[p]
        pose[:] = starts[p]
        scores[p] = -1.0
        if not is_ambiguous:
            scores[p], likelihoods[p] = _refine_and_measure(
                pose,
                predicted[p],
                priors[p],
                beams,
                table,
                occupied,
                ends,
                means,
                search,
                search.looks,
                points,
                which,
                factors[p],
            )
        if is_ambiguous or scores[p] < expected:
            x, y, yaw, _ = climb(
                drawn[p, 0],
                drawn[p, 1],
                drawn[p, 2],
                beams,
                1,
                table,
                occupied,
                ends,
                means,
                search.kernel,
                search.score_sigma,
                search.step,
                search.turn,
                search.halvings,
            )
            other = np.array((x, y, yaw))
            value, likelihood = _refine_and_measure(
                other,
                predicted[p],
                priors[p],
                beams,
                table,
                occupied,
                ends,
                means,
                search,
                search.looks,
                points,
                which,
                lower,
            )
            if value > scores[p]:
                scores[p], likelihoods[p] = value, likelihood
                pose[:] = other
                factors[p] = lower
        if not scores[p] > search.least_score:
            pose[:] = drawn[p]
            likelihoods[p] = _likelihood_at(pose, beams, table, occupied, ends, means, search, points, which)
