"""Aligns two sets of surface points to a fraction of a cell, with the information of the result."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gridslam.kernels.links import Surfaces, align
from gridslam.loop_closure.local_map import SurfacePoints

FAR_M = 1e6
"""m: seen from so far to the west, points are sorted by their y."""


@dataclass(frozen=True)
class Refined:
    """A relative pose with its information.

    Attributes:
        query_in_reference: (3,) the pose.
        normal_matrix: (3, 3) sum of J^T J over the pairs of points. J is the derivative of a pair's distance
            by a step (x, y in metres, yaw in radians) in the query's frame.
        pairs: number of pairs; 0: too few fit, and the pose is of no use.
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
    pose, matrix = np.array(start, float), np.zeros((3, 3))
    pairs, rms_m = align(_sorted(reference), _sorted(query), pose, gate_m, 0.0, matrix)
    return Refined(pose, matrix, pairs, rms_m)


def normal_matrix(surface: SurfacePoints) -> np.ndarray:
    """Return the information of a scan's surfaces on a small step in its own frame: sum of J^T J, (3, 3)."""
    flat = np.isfinite(surface.normals_xy[:, 0])
    points, normals = surface.points_xy_m[flat], surface.normals_xy[flat]
    lever = points[:, 0] * normals[:, 1] - points[:, 1] * normals[:, 0]
    jacobian = np.column_stack([normals, lever])
    return jacobian.T @ jacobian


def _sorted(surface: SurfacePoints) -> Surfaces:
    """Return the points with a normal, in the order of their bearings."""
    flat = np.isfinite(surface.normals_xy[:, 0])
    points, normals = surface.points_xy_m[flat], surface.normals_xy[flat]
    bearings = np.arctan2(points[:, 1], points[:, 0] + FAR_M)
    order = np.argsort(bearings, kind="stable")
    return Surfaces(points[order], normals[order], bearings[order], np.array([-FAR_M, 0.0]))
