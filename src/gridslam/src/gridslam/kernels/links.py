"""Aligns two scans: point to line, robust, each point with the nearest of the other scan.

Points (n, 2) are in metres in the base frame, with the unit normals (n, 2) of their surfaces. Those of the
reference are sorted by their bearing (n,) from the reference's lidar.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from gridslam.kernels.least_squares import factor, inverse, keep_strongest, solve

FACING_COS = math.cos(math.radians(40.0))
"""Normals that differ by more belong to different surfaces."""
STEP_M, STEP_RAD = 1e-4, 1e-5
"""Smaller steps end the iteration."""
ROUNDS_MAX = 20
DAMPING = 1e-3
"""Keeps the pose in directions that the surfaces do not determine, for example along a wall."""
GATE_FALL = 0.8
"""The gate shrinks by this in each round, down to half."""
WEIGHT_SHARE = 0.25
"""A pair this share of the gate apart has half the weight of one that touches."""
OPEN_SHARE = 0.01
"""A direction with less than this share of a pair's information, on average, is open: see `covariance`."""
OPEN_INFORMATION = 1e-2
"""1/m2 or 1/rad2: what is left of the information in an open direction."""


class Surfaces(NamedTuple):
    """A scan's points on flat surfaces."""

    points: np.ndarray
    normals: np.ndarray
    bearings: np.ndarray
    lidar: np.ndarray
    """(2,) where the bearings begin, m."""


@njit(cache=True, nogil=True)
def nearest_by_bearing(surfaces: Surfaces, x: float, y: float, gate: float) -> int:
    """Return the index of the point nearest to x, y, nearer than the gate; -1: there is none."""
    points, _, bearings, lidar = surfaces
    count = len(bearings)
    dx, dy = x - lidar[0], y - lidar[1]
    first = int(np.searchsorted(bearings, math.atan2(dy, dx)))
    best, found = gate * gate, -1
    for direction in (1, -1):
        i = first if direction == 1 else first - 1
        for _ in range(count):
            if i == count:
                i = 0
            elif i < 0:
                i = count - 1
            from_x, from_y = points[i, 0] - lidar[0], points[i, 1] - lidar[1]
            ahead, aside = dx * from_x + dy * from_y, direction * (dx * from_y - dy * from_x)
            # No point farther round can be nearer than the ray from the lidar through this one, up to a
            # quarter turn, and than the lidar from there to half a turn.
            if ahead > 0.0:
                if aside > 0.0 and aside * aside > best * (from_x * from_x + from_y * from_y):
                    break
            elif aside < 0.0 or dx * dx + dy * dy > best:
                break
            square = (points[i, 0] - x) ** 2 + (points[i, 1] - y) ** 2
            if square < best:
                best, found = square, i
            i += direction
    return found


@njit(cache=True, nogil=True)
def align(
    reference: Surfaces, query: Surfaces, pose: np.ndarray, gate_m: float, matrix: np.ndarray
) -> tuple[int, float]:
    """Move ``pose`` (3,) of the query in the reference's frame to where the surfaces fit.

    ``matrix`` (3, 3) gets the sum of J^T J over the pairs: J is the derivative of a pair's distance by a step
    in the query's frame. Returns the number of pairs, and the root mean square of their distances.
    """
    gradient, lower, gate = np.zeros(3), np.zeros((3, 3)), gate_m
    weighted, jacobian = np.zeros((3, 3)), np.zeros(3)
    pairs, squares = 0, 0.0
    for _ in range(ROUNDS_MAX):
        matrix[:], weighted[:], gradient[:] = 0.0, 0.0, 0.0
        pairs, squares = 0, 0.0
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        for i in range(query.points.shape[0]):
            px, py = query.points[i, 0], query.points[i, 1]
            x, y = pose[0] + cos * px - sin * py, pose[1] + sin * px + cos * py
            j = nearest_by_bearing(reference, x, y, gate)
            if j < 0:
                continue
            nx, ny = reference.normals[j, 0], reference.normals[j, 1]
            # the reference's normal in the query's frame
            qx, qy = cos * nx + sin * ny, -sin * nx + cos * ny
            if qx * query.normals[i, 0] + qy * query.normals[i, 1] < FACING_COS:
                continue
            distance = (x - reference.points[j, 0]) * nx + (y - reference.points[j, 1]) * ny
            weight = 1.0 / (1.0 + (distance / (WEIGHT_SHARE * gate)) ** 2)
            jacobian[0], jacobian[1], jacobian[2] = qx, qy, px * qy - py * qx
            pairs += 1
            squares += distance * distance
            for k in range(3):
                gradient[k] -= weight * jacobian[k] * distance
                for m in range(3):
                    matrix[k, m] += jacobian[k] * jacobian[m]
                    weighted[k, m] += weight * jacobian[k] * jacobian[m]
        if pairs < 3:
            return 0, math.inf
        for k in range(3):
            weighted[k, k] += DAMPING
        factor(weighted, lower)
        solve(lower, gradient)
        pose[0] += cos * gradient[0] - sin * gradient[1]
        pose[1] += sin * gradient[0] + cos * gradient[1]
        pose[2] += gradient[2]
        gate = max(0.5 * gate_m, GATE_FALL * gate)
        if math.hypot(gradient[0], gradient[1]) < STEP_M and abs(gradient[2]) < STEP_RAD:
            break
    return pairs, math.sqrt(squares / pairs)


@njit(cache=True, nogil=True)
def covariance(matrix: np.ndarray, pairs: int, points_most: float, sigma_m: float) -> np.ndarray:
    """Return the covariance (3, 3) of an alignment from its sum of J^T J over this many pairs.

    At most ``points_most`` of the pairs are independent, with this standard deviation of their distances.
    Normals err, too. So a bare wall seems to measure a little along itself. A direction of the plane with so
    little information counts as open. ``matrix`` is used up.
    """
    xx, yx, yy = matrix[0, 0], matrix[1, 0], matrix[1, 1]
    if 0.5 * (xx + yy) - math.hypot(0.5 * (xx - yy), yx) < OPEN_SHARE * pairs:
        keep_strongest(matrix, np.zeros(3))
    return inverse(min(1.0, points_most / pairs) / sigma_m**2 * matrix + OPEN_INFORMATION * np.eye(3))
