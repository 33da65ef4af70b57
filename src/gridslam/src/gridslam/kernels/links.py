"""Aligns two scans: point to line, robust, each point with the nearest of the other scan.

Points (n, 2) are in metres in the base frame, with the unit normals (n, 2) of their surfaces. Those of the
reference are sorted by their bearing (n,) from the reference's lidar.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gridslam.kernels.least_squares import factor, inverse, keep_strongest, solve
from kernel_cache.compiler import njit

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
PAIRS_MIN = 20
FIRST_HOPE, HOPE = 0.3, 0.5
"""An alignment is given up once it has less than this of the share of pairs that it must have: a coarse one,
and any other.
"""


class Surfaces(NamedTuple):
    """A scan's points on flat surfaces."""

    points: np.ndarray
    normals: np.ndarray
    bearings: np.ndarray
    lidar: np.ndarray
    """(2,) where the bearings begin, m."""


class Scans(NamedTuple):
    """The surfaces of several scans, one after the other; there may be room for more."""

    points: np.ndarray
    normals: np.ndarray
    bearings: np.ndarray
    lidars: np.ndarray
    """(k, 2) of each scan."""
    starts: np.ndarray
    """(k + 1,) where each scan's points begin."""


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
def _pairs(reference: Surfaces, query: Surfaces, pose: np.ndarray, gate: float, partners: np.ndarray) -> int:
    """Write the reference's partner of every point of the query, or -1; return the number of pairs."""
    cos, sin, count = math.cos(pose[2]), math.sin(pose[2]), 0
    for i in range(query.points.shape[0]):
        px, py = query.points[i, 0], query.points[i, 1]
        j = nearest_by_bearing(reference, pose[0] + cos * px - sin * py, pose[1] + sin * px + cos * py, gate)
        if j >= 0:
            nx, ny = reference.normals[j, 0], reference.normals[j, 1]
            qx, qy = cos * nx + sin * ny, -sin * nx + cos * ny
            if qx * query.normals[i, 0] + qy * query.normals[i, 1] < FACING_COS:
                j = -1
        partners[i] = j
        count += j >= 0
    return count


@njit(cache=True, nogil=True)
def _step(
    reference: Surfaces,
    query: Surfaces,
    pose: np.ndarray,
    scale: float,
    partners: np.ndarray,
    matrix: np.ndarray,
    step: np.ndarray,
) -> float:
    """Move the pose by one step of Gauss-Newton, for these pairs; return the sum of their squared distances.

    A pair ``scale`` apart has half the weight of one that touches. ``matrix`` (3, 3) gets the sum of J^T J,
    ``step`` (3,) the step in the query's frame.
    """
    weighted, lower, jacobian, squares = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros(3), 0.0
    matrix[:], step[:] = 0.0, 0.0
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    for i in range(query.points.shape[0]):
        j = partners[i]
        if j < 0:
            continue
        px, py = query.points[i, 0], query.points[i, 1]
        nx, ny = reference.normals[j, 0], reference.normals[j, 1]
        from_x = pose[0] + cos * px - sin * py - reference.points[j, 0]
        from_y = pose[1] + sin * px + cos * py - reference.points[j, 1]
        distance = from_x * nx + from_y * ny
        weight = 1.0 / (1.0 + (distance / scale) ** 2)
        # the reference's normal in the query's frame
        qx, qy = cos * nx + sin * ny, -sin * nx + cos * ny
        jacobian[0], jacobian[1], jacobian[2] = qx, qy, px * qy - py * qx
        squares += distance * distance
        for k in range(3):
            step[k] -= weight * jacobian[k] * distance
            for m in range(k + 1):
                product = jacobian[k] * jacobian[m]
                matrix[k, m] += product
                weighted[k, m] += weight * product
    for k in range(3):
        weighted[k, k] += DAMPING
        for m in range(k):
            matrix[m, k] = matrix[k, m]
    factor(weighted, lower)
    solve(lower, step)
    pose[0] += cos * step[0] - sin * step[1]
    pose[1] += sin * step[0] + cos * step[1]
    pose[2] += step[2]
    return squares


@njit(cache=True, nogil=True)
def align(
    reference: Surfaces,
    query: Surfaces,
    pose: np.ndarray,
    gate_m: float,
    share_min: float,
    matrix: np.ndarray,
) -> tuple[int, float]:
    """Move ``pose`` (3,) of the query in the reference's frame to where the surfaces fit.

    ``matrix`` (3, 3) gets the sum of J^T J over the pairs: J is the derivative of a pair's distance by a step
    in the query's frame. Returns the number of pairs, and the root mean square of their distances: 0 pairs if
    at any time less than ``share_min`` of the query's points has one.
    """
    count, gate = query.points.shape[0], gate_m
    partners, step = np.full(count, -1), np.zeros(3)
    pairs, squares = 0, 0.0
    for _ in range(ROUNDS_MAX):
        pairs = _pairs(reference, query, pose, gate, partners)
        if pairs < max(3.0, share_min * count):
            return 0, math.inf
        squares = _step(reference, query, pose, WEIGHT_SHARE * gate, partners, matrix, step)
        gate = max(0.5 * gate_m, GATE_FALL * gate)
        if math.hypot(step[0], step[1]) < STEP_M and abs(step[2]) < STEP_RAD:
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


@njit(cache=True, nogil=True)
def mean_shift(query: Surfaces, first: np.ndarray, second: np.ndarray) -> float:
    """Return how far apart two poses (3,) put the query's points on average, m."""
    a, b = math.cos(second[2]) - math.cos(first[2]), math.sin(second[2]) - math.sin(first[2])
    dx, dy, total = second[0] - first[0], second[1] - first[1], 0.0
    for x, y in query.points:
        total += math.hypot(dx + a * x - b * y, dy + b * x + a * y)
    return total / max(1, query.points.shape[0])


@njit(cache=True, nogil=True)
def measure(
    reference: Surfaces,
    query: Surfaces,
    poses: np.ndarray,
    gates_m: tuple[float, float],
    share_min: float,
    rms_max_m: float,
    points_most: float,
    sigma_m: float,
    found: np.ndarray,
) -> bool:
    """Align two scans, and write the covariance into ``found`` (3, 3). Return whether enough of them fits.

    The search begins at each of the predictions ``poses`` (k, 3), if it is farther than the gate from the
    first one. The pose with the most pairs is written into ``poses[0]``. The first of the gates is that of a
    coarse alignment, 0 for none. ``share_min`` of the query's points, at least PAIRS_MIN, must have a pair.
    """
    predicted, matrix, most = poses[0].copy(), np.zeros((3, 3)), 0
    least = max(float(PAIRS_MIN), share_min * query.points.shape[0])
    for i in range(poses.shape[0]):
        pose = poses[i].copy()
        if i > 0 and mean_shift(query, predicted, pose) <= gates_m[1]:
            continue
        if (
            gates_m[0] > 0.0
            and align(reference, query, pose, gates_m[0], FIRST_HOPE * share_min, matrix)[0] == 0
        ):
            continue
        pairs, rms_m = align(reference, query, pose, gates_m[1], HOPE * share_min, matrix)
        if pairs >= least and rms_m <= rms_max_m and pairs > most:
            most = pairs
            poses[0] = pose
            found[:] = covariance(matrix, pairs, points_most, sigma_m)
    return most > 0


@njit(cache=True, nogil=True)
def _scan(scans: Scans, node: int) -> Surfaces:
    begin, end = scans.starts[node], scans.starts[node + 1]
    return Surfaces(
        scans.points[begin:end], scans.normals[begin:end], scans.bearings[begin:end], scans.lidars[node]
    )


@njit(cache=True, nogil=True)
def measure_pairs(
    scans: Scans,
    pairs: np.ndarray,
    poses: np.ndarray,
    most: int,
    gates_m: tuple[float, float],
    share_min: float,
    rms_max_m: float,
    points_most: float,
    sigma_m: float,
    covariances: np.ndarray,
    are_found: np.ndarray,
) -> None:
    """Align pairs (m, 2) of scans, older and newer, as `measure` does, until ``most`` of them are found.

    ``poses`` (m, k, 3) are the predictions, ``covariances`` (m, 3, 3) and ``are_found`` (m,) the results.
    """
    count = 0
    for i in range(pairs.shape[0]):
        older, newer, found = _scan(scans, pairs[i, 0]), _scan(scans, pairs[i, 1]), covariances[i]
        are_found[i] = measure(
            older, newer, poses[i], gates_m, share_min, rms_max_m, points_most, sigma_m, found
        )
        count += are_found[i]
        if count == most:
            break


@njit(cache=True, nogil=True)
def nearest_earlier(
    poses: np.ndarray, way_m: np.ndarray, first: int, radius_m: float, apart_m: float, most: int
) -> np.ndarray:
    """Return (k - first, most): for each node from ``first`` on the nearest nodes of earlier passes, or -1.

    They are within a radius, and at least ``apart_m`` of the way (k,) before the node. The nearest is first.
    """
    count = poses.shape[0]
    found, squares = np.full((count - first, most), -1), np.empty(most)
    for newer in range(first, count):
        nodes = found[newer - first]
        squares[:] = radius_m * radius_m
        for older in range(newer):
            if way_m[older] >= way_m[newer] - apart_m:
                break
            square = (poses[older, 0] - poses[newer, 0]) ** 2 + (poses[older, 1] - poses[newer, 1]) ** 2
            if square >= squares[most - 1]:
                continue
            place = most - 1
            while place > 0 and square < squares[place - 1]:
                nodes[place], squares[place] = nodes[place - 1], squares[place - 1]
                place -= 1
            nodes[place], squares[place] = older, square
    return found
