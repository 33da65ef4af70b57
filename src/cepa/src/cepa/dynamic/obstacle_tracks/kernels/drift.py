"""The odometry's drift from scan to scan, as the tracks of standing things tell it."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.obstacle_tracks import DRIFT_RESIDUAL_M, DRIFT_SHIFT_M, DRIFT_TURN_RAD
from cepa.dynamic.obstacle_tracks.kernels.columns import (
    CUT_FIRST,
    CUT_LAST,
    HIDDEN,
    MIDDLE_X,
    MIDDLE_Y,
    NORMALS,
    SURFACE_X,
    UNSEEN,
    VX,
    VY,
)
from cepa.dynamic.obstacle_tracks.kernels.sides import reaches_of, shift_of
from kernel_cache.compiler import njit

FIXED = 1e12
"""A weight that leaves no room for a correction."""


@njit(cache=True)
def align(
    clusters: np.ndarray,
    tracks: np.ndarray,
    owners: np.ndarray,
    moving: np.ndarray,
    points: np.ndarray,
    pose: np.ndarray,
    dt: float,
    least: int,
    limits: np.ndarray,
    motion: np.ndarray,
) -> bool:
    """Fill ``motion`` (3: x, y in m, turn in rad about the lidar) with what lays a scan on standing things.

    They are the tracks that are not ``moving`` (t,) and were seen in the last scan, with known sides and all
    of their clusters in sight. Outliers count little. Returns whether there are at least ``least`` of them,
    and more than tracks in sight that move. With fewer, what moves could not be told from an error of the
    odometry. If there are, the points, the clusters and the pose are moved by it.

    limits (2, 3): the least and the greatest ``motion``. Many things that move alike look as an error of the
    odometry does, but no odometry is so bad. Where both are 0 nothing is corrected.
    """
    motion[:] = 0.0
    moves = 0
    for t in range(tracks.shape[0]):
        if owners[t] >= 0 and moving[t]:
            moves += 1
    shifts, reaches = np.full((tracks.shape[0], 2), math.nan), np.empty(NORMALS.shape[0])
    are_new = np.empty(NORMALS.shape[0], np.bool_)
    for t in range(tracks.shape[0]):
        if owners[t] < 0 or moving[t] or tracks[t, UNSEEN] > 1.5 * dt:
            continue
        cluster = clusters[owners[t]]
        if max(cluster[CUT_FIRST], cluster[CUT_LAST]) < HIDDEN:
            reaches_of(points, cluster, pose, HIDDEN, reaches)
            if shift_of(reaches, tracks[t], shifts[t], are_new) == 0:
                shifts[t] = math.nan
    for _ in range(4):
        matrix = np.diag(np.array([1.0 / DRIFT_SHIFT_M**2, 1.0 / DRIFT_SHIFT_M**2, 1.0 / DRIFT_TURN_RAD**2]))
        for k in range(3):
            if limits[0, k] == limits[1, k]:
                matrix[k, k] = FIXED
        right = np.zeros(3)
        count = 0
        for t in range(tracks.shape[0]):
            if math.isnan(shifts[t, 0]):
                continue
            count += 1
            cluster = clusters[owners[t]]
            ax, ay = cluster[MIDDLE_X] - pose[0], cluster[MIDDLE_Y] - pose[1]
            rx, ry = -shifts[t, 0] - dt * tracks[t, VX], -shifts[t, 1] - dt * tracks[t, VY]
            ex, ey = rx - motion[0] + motion[2] * ay, ry - motion[1] - motion[2] * ax
            w = 1.0 / (DRIFT_RESIDUAL_M**2 + ex * ex + ey * ey)
            matrix[0, 0] += w
            matrix[1, 1] += w
            matrix[0, 2] -= w * ay
            matrix[1, 2] += w * ax
            matrix[2, 2] += w * (ax * ax + ay * ay)
            right[0] += w * rx
            right[1] += w * ry
            right[2] += w * (ax * ry - ay * rx)
        if count < max(least, moves + 1):
            motion[:] = 0.0
            return False
        matrix[2, 0], matrix[2, 1] = matrix[0, 2], matrix[1, 2]
        motion[:] = np.linalg.solve(matrix, right)
    for k in range(3):
        motion[k] = min(max(motion[k], limits[0, k]), limits[1, k])
    _move_scan(clusters, points, pose, motion)
    return True


@njit(cache=True)
def _move_scan(clusters: np.ndarray, points: np.ndarray, pose: np.ndarray, motion: np.ndarray) -> None:
    """Move a scan by ``motion`` (3,): turn it about the lidar, and shift it."""
    c, s = math.cos(motion[2]), math.sin(motion[2])
    shift_x = pose[0] + motion[0] - c * pose[0] + s * pose[1]
    shift_y = pose[1] + motion[1] - s * pose[0] - c * pose[1]
    for k in range(points.shape[0]):
        x, y = points[k]
        points[k, 0], points[k, 1] = c * x - s * y + shift_x, s * x + c * y + shift_y
    for k in range(clusters.shape[0]):
        for column in (MIDDLE_X, SURFACE_X):
            x, y = clusters[k, column], clusters[k, column + 1]
            clusters[k, column] = c * x - s * y + shift_x
            clusters[k, column + 1] = s * x + c * y + shift_y
    pose += motion
