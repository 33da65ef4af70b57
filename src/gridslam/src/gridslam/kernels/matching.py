"""How well a scan fits a particle's map at a pose, and the pose at which it fits best.

Everything is in cells from the corner of the particle's table and radians. ``beams`` (n, 7) hold, in the base
frame: the beam's end x, y; a step of sqrt(2) cells along the beam, x, y; the normal of the surface it hit, x,
y; and how much an offset along that surface counts (1: as much as across, where the surface is not known).

A map (table, occupied, ends, means) is the particle's table of tiles, every tile's occupied cells as one bit
each, and where the means of its cells' hits are.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from gridslam.kernels.tiles import MASK, PARTS, SIDE, SIDE_BITS

PART = 1.0 / PARTS
"""Cells: unit of the means."""
MARGIN = 3
"""Cells, beyond kernelSize, that a search may look away from a beam's end."""
PIVOT_MIN = 1e-9
CONVERGED_CELLS = 0.01
CONVERGED_RAD = 1e-4


@njit(cache=True, nogil=True, inline="always")
def _is_occupied(x, y, table, occupied):
    return (np.int64(occupied[table[y >> SIDE_BITS, x >> SIDE_BITS], y & MASK]) >> (x & MASK)) & 1


@njit(cache=True, nogil=True, inline="always")
def _nearest(px, py, step_x, step_y, nx, ny, along, table, occupied, ends, means, kernel):
    """Return (d2, rx, ry): the offset of a beam's end from the nearest point of the map, d2 < 0 if none.

    Points are means of occupied cells within ``kernel`` cells whose neighbour towards the lidar is not
    occupied.
    """
    ix, iy = int(np.floor(px)), int(np.floor(py))
    back_x, back_y = int(np.floor(px - step_x)) - ix, int(np.floor(py - step_y)) - iy
    best, rx, ry = -1.0, 0.0, 0.0
    left = ix - kernel
    tile_x, shift, width = left >> SIDE_BITS, left & MASK, 2 * kernel + 1
    for y in range(iy - kernel, iy + kernel + 1):
        tile_y, row = y >> SIDE_BITS, y & MASK
        bits = np.int64(occupied[table[tile_y, tile_x], row]) >> shift
        if shift + width > 32:
            bits |= np.int64(occupied[table[tile_y, tile_x + 1], row]) << (32 - shift)
        bits &= (1 << width) - 1
        x = left
        while bits:
            if bits & 1 and not _is_occupied(x + back_x, y + back_y, table, occupied):
                tile = table[tile_y, x >> SIDE_BITS]
                entry, cell = ends[tile], row * SIDE + (x & MASK)
                dx = px - x - PART * means[entry, cell, 0]
                dy = py - y - PART * means[entry, cell, 1]
                across = dx * nx + dy * ny
                d2 = across * across + along * (dx * dx + dy * dy - across * across)
                if best < 0.0 or d2 < best:
                    best, rx, ry = d2, dx, dy
            bits >>= 1
            x += 1
    return best, rx, ry


@njit(cache=True, nogil=True, inline="always")
def _look(beams, i, x, y, cos, sin, table, occupied, ends, means, kernel):
    """Return (d2, rx, ry, qx, qy, nx, ny) of a beam: its offset, its end from the base, its normal."""
    qx, qy = cos * beams[i, 0] - sin * beams[i, 1], sin * beams[i, 0] + cos * beams[i, 1]
    nx, ny = cos * beams[i, 4] - sin * beams[i, 5], sin * beams[i, 4] + cos * beams[i, 5]
    px, py = x + qx, y + qy
    least = kernel + MARGIN
    most_x = (table.shape[1] << SIDE_BITS) - least
    most_y = (table.shape[0] << SIDE_BITS) - least
    if not (least <= px < most_x and least <= py < most_y):
        return -1.0, 0.0, 0.0, qx, qy, nx, ny
    step_x, step_y = cos * beams[i, 2] - sin * beams[i, 3], sin * beams[i, 2] + cos * beams[i, 3]
    d2, rx, ry = _nearest(px, py, step_x, step_y, nx, ny, beams[i, 6], table, occupied, ends, means, kernel)
    return d2, rx, ry, qx, qy, nx, ny


@njit(cache=True, nogil=True)
def score(x, y, yaw, beams, every, table, occupied, ends, means, kernel, sigma):
    """Sum of exp(-d2 / sigma) over every ``every``-th beam that has a point of the map near."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    total = 0.0
    for i in range(0, beams.shape[0], every):
        d2, _, _, _, _, _, _ = _look(beams, i, x, y, cos, sin, table, occupied, ends, means, kernel)
        if d2 >= 0.0:
            total += math.exp(-d2 / sigma)
    return total


@njit(cache=True, nogil=True)
def measure(x, y, yaw, beams, table, occupied, ends, means, kernel, score_sigma, likelihood_sigma, missed):
    """Return the score and the log-likelihood of a pose.

    The latter is the sum of -d2 / likelihood_sigma, or of ``missed`` where the map has no point near.
    """
    cos, sin = math.cos(yaw), math.sin(yaw)
    total, likelihood = 0.0, 0.0
    for i in range(beams.shape[0]):
        d2, _, _, _, _, _, _ = _look(beams, i, x, y, cos, sin, table, occupied, ends, means, kernel)
        if d2 >= 0.0:
            total += math.exp(-d2 / score_sigma)
            likelihood -= d2 / likelihood_sigma
        else:
            likelihood += missed
    return total, likelihood


@njit(cache=True, nogil=True)
def climb(x, y, yaw, beams, every, table, occupied, ends, means, kernel, sigma, step, turn, halvings):
    """Hill climbing over the score: the best of six steps, and halved steps where none is better."""
    best = score(x, y, yaw, beams, every, table, occupied, ends, means, kernel, sigma)
    halved = 0
    while True:
        start_x, start_y, start_yaw, better = x, y, yaw, False
        for move in range(6):
            sign = 1.0 - 2.0 * (move & 1)
            to_x = start_x + (sign * step if move < 2 else 0.0)
            to_y = start_y + (sign * step if 2 <= move < 4 else 0.0)
            to_yaw = start_yaw + (sign * turn if move >= 4 else 0.0)
            value = score(to_x, to_y, to_yaw, beams, every, table, occupied, ends, means, kernel, sigma)
            if value > best:
                best, x, y, yaw, better = value, to_x, to_y, to_yaw, True
        if not better:
            if halved == halvings:
                return x, y, yaw, best
            halved += 1
            step *= 0.5
            turn *= 0.5


@njit(cache=True, nogil=True, inline="always")
def _factor(a, lower):
    """Cholesky factor of a symmetric 3 x 3 matrix, of which the lower triangle is read."""
    for i in range(3):
        for j in range(i + 1):
            value = a[i, j]
            for k in range(j):
                value -= lower[i, k] * lower[j, k]
            lower[i, j] = math.sqrt(max(value, PIVOT_MIN)) if i == j else value / lower[j, j]


@njit(cache=True, nogil=True, inline="always")
def _solve_upper(lower, b):
    """Overwrite b with the solution of lower' x = b."""
    for i in range(2, -1, -1):
        for k in range(i + 1, 3):
            b[i] -= lower[k, i] * b[k]
        b[i] /= lower[i, i]


@njit(cache=True, nogil=True, inline="always")
def _solve(lower, b):
    """Overwrite b with the solution of lower lower' x = b."""
    for i in range(3):
        for k in range(i):
            b[i] -= lower[i, k] * b[k]
        b[i] /= lower[i, i]
    _solve_upper(lower, b)


@njit(cache=True, nogil=True, inline="always")
def _add(information, gradient, weight, jx, jy, jt, residual):
    information[0, 0] += weight * jx * jx
    information[1, 0] += weight * jy * jx
    information[1, 1] += weight * jy * jy
    information[2, 0] += weight * jt * jx
    information[2, 1] += weight * jt * jy
    information[2, 2] += weight * jt * jt
    gradient[0] -= weight * jx * residual
    gradient[1] -= weight * jy * residual
    gradient[2] -= weight * jt * residual


@njit(cache=True, nogil=True)
def linearise(x, y, yaw, beams, table, occupied, ends, means, kernel, sigma, information, gradient):
    """Add every beam's part of the normal equations, weighted by exp(-d2 / sigma); return the score.

    Only the lower triangle of ``information`` (3, 3) is written; ``gradient`` (3,) points uphill.
    """
    cos, sin = math.cos(yaw), math.sin(yaw)
    total = 0.0
    for i in range(beams.shape[0]):
        d2, rx, ry, qx, qy, nx, ny = _look(beams, i, x, y, cos, sin, table, occupied, ends, means, kernel)
        if d2 < 0.0:
            continue
        weight = math.exp(-d2 / sigma)
        total += weight
        _add(information, gradient, weight, nx, ny, ny * qx - nx * qy, nx * rx + ny * ry)
        along = weight * beams[i, 6]
        _add(information, gradient, along, -ny, nx, nx * qx + ny * qy, nx * ry - ny * rx)
    return total


@njit(cache=True, nogil=True)
def refine(pose, prior_pose, prior, beams, table, occupied, ends, means, kernel, sigma, steps, lower):
    """Move ``pose`` (3,) by Gauss-Newton to the maximum of score and prior; return the score.

    ``prior`` (3, 3) is the information of ``prior_pose``, in units of one beam's. ``lower`` (3, 3)
    becomes the Cholesky factor of the information at the maximum.
    """
    information, gradient = np.empty((3, 3)), np.empty(3)
    total = 0.0
    for _ in range(steps):
        for i in range(3):
            gradient[i] = 0.0
            for j in range(3):
                information[i, j] = prior[i, j]
                gradient[i] -= prior[i, j] * (pose[j] - prior_pose[j])
        total = linearise(
            pose[0],
            pose[1],
            pose[2],
            beams,
            table,
            occupied,
            ends,
            means,
            kernel,
            sigma,
            information,
            gradient,
        )
        _factor(information, lower)
        _solve(lower, gradient)
        pose += gradient
        if abs(gradient[0]) + abs(gradient[1]) < CONVERGED_CELLS and abs(gradient[2]) < CONVERGED_RAD:
            break
    return total


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
    steps: int


@njit(cache=True, nogil=True)
def find_mode(candidates, beams, every, search, table, occupied, ends, means, mode):
    """Climb from every candidate (c, 3) with every ``every``-th beam; ``mode`` (3,) takes the best end.

    Returns its score with all beams.
    """
    top = -1.0
    kernel, sigma = search.kernel, search.score_sigma
    for c in range(candidates.shape[0]):
        x, y, yaw = candidates[c, 0], candidates[c, 1], candidates[c, 2]
        x, y, yaw, value = climb(
            x, y, yaw, beams, every, table, occupied, ends, means, kernel, sigma, search.step, search.turn, 1
        )
        if value > top:
            top = value
            mode[0], mode[1], mode[2] = x, y, yaw
    return score(mode[0], mode[1], mode[2], beams, 1, table, occupied, ends, means, kernel, sigma)


@njit(cache=True, nogil=True)
def _refine_and_measure(pose, predicted, prior, beams, table, occupied, ends, means, search, lower):
    """Move a pose to the maximum that Gauss-Newton finds from it; return its score and log-likelihood."""
    kernel, sigma = search.kernel, search.refine_sigma
    refine(pose, predicted, prior, beams, table, occupied, ends, means, kernel, sigma, search.steps, lower)
    sigmas = (search.score_sigma, search.likelihood_sigma)
    return measure(
        pose[0],
        pose[1],
        pose[2],
        beams,
        table,
        occupied,
        ends,
        means,
        kernel,
        sigmas[0],
        sigmas[1],
        search.missed,
    )


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
    draw. ``poses``, ``scores``, ``likelihoods`` (log) and ``factors`` (Cholesky, of the information) take the
    results.
    """
    lower = np.zeros((3, 3))
    for p in range(first, last):
        table, pose = tables[p], poses[p]
        pose[:] = starts[p]
        scores[p] = -1.0
        if not is_ambiguous:
            scores[p], likelihoods[p] = _refine_and_measure(
                pose, predicted[p], priors[p], beams, table, occupied, ends, means, search, factors[p]
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
                other, predicted[p], priors[p], beams, table, occupied, ends, means, search, lower
            )
            if value > scores[p]:
                scores[p], likelihoods[p] = value, likelihood
                pose[:] = other
                factors[p] = lower


@njit(cache=True, nogil=True)
def scatter(factors, noise, poses):
    """Move poses (P, 3) by noise (P, 3) that has the covariance of the factors' information."""
    for p in range(poses.shape[0]):
        shift = noise[p].copy()
        _solve_upper(factors[p], shift)
        poses[p] += shift
