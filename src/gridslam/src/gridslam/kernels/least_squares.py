"""Least squares for the pose that fits a map's points and a prior best: three unknowns."""

from __future__ import annotations

import math

import numpy as np

from gridslam.kernels.nearest import NearestPoints, offset
from kernel_cache.compiler import njit

PIVOT_MIN = 1e-9
OBSERVED_SHARE = 0.01
"""A direction in which beams tell less than this share of what they tell across it is not observed."""


@njit(cache=True, nogil=True)
def linearise(
    x: float,
    y: float,
    yaw: float,
    beams: np.ndarray,
    nearby: NearestPoints,
    found: int,
    sigma: float,
    information: np.ndarray,
    gradient: np.ndarray,
) -> None:
    """Add every beam's part of the normal equations, weighted by exp(-d2 / sigma).

    The first ``found`` of the ``nearby`` points count.
    Only the lower triangle of ``information`` (3, 3) is written; ``gradient`` (3,) points uphill.
    """
    cos, sin = math.cos(yaw), math.sin(yaw)
    points, which = nearby
    xx, yx, yy, tx, ty, tt, gx, gy, gt = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(found):
        i = which[k]
        rx, ry, qx, qy, nx, ny, d2 = offset(x, y, cos, sin, beams, i, points[k, 0], points[k, 1])
        weight, along = math.exp(-d2 / sigma), beams[i, 6]
        # cost of an offset: weight (n n' + along t t'), with the tangent t = (-ny, nx)
        mxx = weight * (nx * nx + along * ny * ny)
        myx = weight * (1.0 - along) * nx * ny
        myy = weight * (ny * ny + along * nx * nx)
        # the derivative of a beam's end by the pose is the unit matrix, and (-qy, qx) by yaw
        mtx, mty = qx * myx - qy * mxx, qx * myy - qy * myx
        xx += mxx
        yx += myx
        yy += myy
        tx += mtx
        ty += mty
        tt += qx * mty - qy * mtx
        gx += mxx * rx + myx * ry
        gy += myx * rx + myy * ry
        gt += mtx * rx + mty * ry
    information[0, 0] += xx
    information[1, 0] += yx
    information[1, 1] += yy
    information[2, 0] += tx
    information[2, 1] += ty
    information[2, 2] += tt
    gradient[0] -= gx
    gradient[1] -= gy
    gradient[2] -= gt


@njit(cache=True, nogil=True)
def ignore_unobserved(information: np.ndarray, gradient: np.ndarray) -> None:
    """Remove what beams tell along the weakest direction of x and y, if it is not observed.

    Along a bare corridor that is noise of the surfaces' normals. Without it the prior decides there.
    Only the lower triangle of ``information`` (3, 3) is read and written.
    """
    xx, yx, yy = information[0, 0], information[1, 0], information[1, 1]
    spread, mean = math.hypot(0.5 * (xx - yy), yx), 0.5 * (xx + yy)
    if mean - spread < OBSERVED_SHARE * (mean + spread):
        keep_strongest(information, gradient)


@njit(cache=True, nogil=True)
def keep_strongest(information: np.ndarray, gradient: np.ndarray) -> None:
    """Remove what is told along the weakest direction of x and y, as `ignore_unobserved` does."""
    xx, yx, yy = information[0, 0], information[1, 0], information[1, 1]
    strongest = 0.5 * math.atan2(2.0 * yx, xx - yy)
    x, y, value = math.cos(strongest), math.sin(strongest), 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), yx)
    information[0, 0], information[1, 0], information[1, 1] = value * x * x, value * x * y, value * y * y
    turn = x * information[2, 0] + y * information[2, 1]
    information[2, 0], information[2, 1] = turn * x, turn * y
    uphill = x * gradient[0] + y * gradient[1]
    gradient[0], gradient[1] = uphill * x, uphill * y


@njit(cache=True, nogil=True)
def add_prior(
    pose: np.ndarray, prior_pose: np.ndarray, prior: np.ndarray, information: np.ndarray, gradient: np.ndarray
) -> None:
    """Add a prior's part of the normal equations; ``prior`` (3, 3) is the information of its pose (3,)."""
    for i in range(3):
        for j in range(3):
            information[i, j] += prior[i, j]
            gradient[i] -= prior[i, j] * (pose[j] - prior_pose[j])


@njit(cache=True, nogil=True)
def factor(a: np.ndarray, lower: np.ndarray) -> None:
    """Write the Cholesky factor of a symmetric 3 x 3 matrix. Only its lower triangle is read."""
    for i in range(3):
        for j in range(i + 1):
            value = a[i, j]
            for k in range(j):
                value -= lower[i, k] * lower[j, k]
            lower[i, j] = math.sqrt(max(value, PIVOT_MIN)) if i == j else value / lower[j, j]


@njit(cache=True, nogil=True)
def solve_upper(lower: np.ndarray, b: np.ndarray) -> None:
    """Overwrite b (3,) with the solution of lower' x = b."""
    for i in range(2, -1, -1):
        for k in range(i + 1, 3):
            b[i] -= lower[k, i] * b[k]
        b[i] /= lower[i, i]


@njit(cache=True, nogil=True)
def solve(lower: np.ndarray, b: np.ndarray) -> None:
    """Overwrite b (3,) with the solution of lower lower' x = b."""
    for i in range(3):
        for k in range(i):
            b[i] -= lower[i, k] * b[k]
        b[i] /= lower[i, i]
    solve_upper(lower, b)


@njit(cache=True, nogil=True)
def inverse(a: np.ndarray) -> np.ndarray:
    """Return the inverse of a symmetric positive definite 3 x 3 matrix. Only its lower triangle is read.

    After each call of numpy's inverse, however small the matrix, a thread of its BLAS keeps a core busy for
    0.1 s.
    """
    lower, inverted = np.zeros((3, 3)), np.eye(3)
    factor(a, lower)
    for row in range(3):
        solve(lower, inverted[row])
    return inverted


@njit(cache=True, nogil=True)
def inverses(matrices: np.ndarray) -> np.ndarray:
    """Return the inverses of symmetric positive definite matrices (n, 3, 3)."""
    inverted = np.empty_like(matrices)
    for i in range(matrices.shape[0]):
        inverted[i] = inverse(matrices[i])
    return inverted


@njit(cache=True, nogil=True)
def scatter(factors: np.ndarray, noise: np.ndarray, poses: np.ndarray) -> None:
    """Move poses (P, 3) by noise (P, 3) that has the covariance of the factors' information."""
    for p in range(poses.shape[0]):
        shift = noise[p].copy()
        solve_upper(factors[p], shift)
        poses[p] += shift
