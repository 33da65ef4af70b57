"""Aligns two sets of surface points to a fraction of a cell, with the information of the result."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from gridslam import se2
from gridslam.loop_closure.local_map import SurfacePoints

FACING_COS = math.cos(math.radians(40.0))  # normals that differ by more belong to different surfaces
STEP_M, STEP_RAD = 1e-4, 1e-5  # smaller steps end the iteration
ROUNDS_MAX = 20


@dataclass(frozen=True)
class Refined:
    """A relative pose with its information.

    Attributes:
        query_in_reference: (3,) the pose.
        normal_matrix: (3, 3) sum of J^T J over the pairs of points. J is the derivative of a pair's distance
            by a step (x, y in metres, yaw in radians) in the query's frame.
        pairs: number of pairs.
        rms_m: root mean square of their distances.
    """

    query_in_reference: np.ndarray
    normal_matrix: np.ndarray
    pairs: int
    rms_m: float


def refine(reference: SurfacePoints, query: SurfacePoints, start: np.ndarray, gate_m: float) -> Refined:
    """Minimise the distances of the query's points from the reference's surfaces (point to line, robust).

    Args:
        reference: its surfaces stay fixed.
        query: its points are moved.
        start: pose (3,) of the query in the reference's frame, with an error of at most about `gate_m`.
        gate_m: points farther apart are no pair.
    """
    flat = np.isfinite(reference.normals_xy[:, 0])
    target, normals = reference.points_xy_m[flat], reference.normals_xy[flat]
    chosen = np.isfinite(query.normals_xy[:, 0])
    points, facing = query.points_xy_m[chosen], query.normals_xy[chosen]
    if not len(target) or not len(points):
        return Refined(start, np.zeros((3, 3)), 0, math.inf)
    tree = cKDTree(target)
    pose, gate = np.array(start, dtype=float), gate_m
    for _ in range(ROUNDS_MAX):
        distance, jacobian, weight = _pairs(tree, target, normals, points, facing, pose, gate)
        if len(distance) < 3:
            return Refined(start, np.zeros((3, 3)), 0, math.inf)
        weighted = jacobian * weight[:, None]
        # The damping keeps the pose in directions that the surfaces do not determine, for example along a
        # wall.
        step = np.linalg.solve(weighted.T @ jacobian + 1e-3 * np.eye(3), -weighted.T @ distance)
        pose = se2.compose(pose, step)
        gate = max(0.5 * gate_m, 0.8 * gate)
        if np.hypot(step[0], step[1]) < STEP_M and abs(step[2]) < STEP_RAD:
            break
    return Refined(pose, weighted.T @ jacobian, len(distance), float(np.sqrt((distance**2).mean())))


def normal_matrix(surface: SurfacePoints) -> np.ndarray:
    """Return the information of a scan's surfaces on a small step in its own frame: sum of J^T J, (3, 3)."""
    flat = np.isfinite(surface.normals_xy[:, 0])
    jacobian = _jacobian(surface.points_xy_m[flat], surface.normals_xy[flat])
    return jacobian.T @ jacobian


def _pairs(
    tree: cKDTree,
    target: np.ndarray,
    normals: np.ndarray,
    points: np.ndarray,
    facing: np.ndarray,
    pose: np.ndarray,
    gate: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return distance, its derivative by a step in the query's frame, and weight, of each pair of points."""
    moved = se2.transform(pose, points)
    gap, nearest = tree.query(moved, distance_upper_bound=gate)
    found = np.isfinite(gap)
    turned = se2.transform((0.0, 0.0, pose[2]), facing)
    found[found] &= (turned[found] * normals[nearest[found]]).sum(axis=1) > FACING_COS
    normal = normals[nearest[found]]
    distance = ((moved[found] - target[nearest[found]]) * normal).sum(axis=1)
    in_query = se2.transform((0.0, 0.0, -pose[2]), normal)
    weight = 1.0 / (1.0 + (distance / (0.25 * gate)) ** 2)
    return distance, _jacobian(points[found], in_query), weight


def _jacobian(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    lever = points[:, 0] * normals[:, 1] - points[:, 1] * normals[:, 0]
    return np.column_stack([normals, lever])
