"""Aligns two sets of surface points to a fraction of a cell, with the information of the result."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gridslam.kernels.least_squares import inverse
from gridslam.kernels.links import Surfaces, align
from gridslam.loop_closure.local_maps.local_map import SurfacePoints
from gridslam.loop_closure.parameters import LoopClosureParameters

FAR_M = 1e6
"""m: seen from so far to the west, points are sorted by their y."""
INFORMATION_MIN = 1e-3
"""1/m2 or 1/rad2: with less in any direction the geometry is degenerate."""


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


def without_weakest(matrix: np.ndarray) -> np.ndarray:
    """Return an information (3, 3) without what it tells along the weakest direction of x and y."""
    weakest = np.append(np.linalg.eigh(matrix[:2, :2])[1][:, 0], 0.0)
    others = np.eye(3) - np.outer(weakest, weakest)
    return others @ matrix @ others


def match_information(matrix: np.ndarray, points: int, parameters: LoopClosureParameters) -> np.ndarray:
    """Return the information (3, 3) of a match from its sum of J^T J over this many points."""
    independent = min(1.0, parameters.match_points / max(1, points))
    return independent * matrix / parameters.match_sigma_m**2


def match_covariance(refined: Refined, parameters: LoopClosureParameters) -> np.ndarray | None:
    """Return the covariance (3, 3) of a match; None: its geometry is degenerate, a direction stays open."""
    p = parameters
    information = match_information(refined.normal_matrix, refined.pairs, p)
    if np.linalg.eigvalsh(information)[0] < INFORMATION_MIN:
        return None
    covariance = inverse(information)
    if math.sqrt(float(np.linalg.eigvalsh(covariance[:2, :2])[-1])) > p.weakest_sigma_max_m:
        return None
    return covariance + np.diag([p.closure_sigma_m**2, p.closure_sigma_m**2, p.closure_sigma_rad**2])


def tells_its_pose(surface: SurfacePoints, parameters: LoopClosureParameters) -> bool:
    """Return whether a map of these points would tell its pose if all of them met what they met before.

    A single pillar does not tell it. To look for one in a wide hall takes long, and finds all others.
    """
    points = int(np.isfinite(surface.normals_xy[:, 0]).sum())
    own = Refined(np.zeros(3), normal_matrix(surface), points, 0.0)
    return match_covariance(own, parameters) is not None


def _sorted(surface: SurfacePoints) -> Surfaces:
    """Return the points with a normal, in the order of their bearings."""
    flat = np.isfinite(surface.normals_xy[:, 0])
    points, normals = surface.points_xy_m[flat], surface.normals_xy[flat]
    bearings = np.arctan2(points[:, 1], points[:, 0] + FAR_M)
    order = np.argsort(bearings, kind="stable")
    return Surfaces(points[order], normals[order], bearings[order], np.array([-FAR_M, 0.0]))
