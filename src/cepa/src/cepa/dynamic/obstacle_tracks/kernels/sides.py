"""The sides of things: how far they reach, and how far they are from their tracks."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.obstacle_tracks import CUT_OFF_M, GRAZING_SINE, SIDES_DAMPING, SIDES_OUTLIER_M
from cepa.dynamic.obstacle_tracks.kernels.columns import (
    CUT_FIRST,
    CUT_LAST,
    END,
    FIRST,
    NORMALS,
    REACH,
    X,
    Y,
)
from kernel_cache.compiler import njit


@njit(cache=True)
def reaches_of(
    points: np.ndarray, cluster: np.ndarray, pose: np.ndarray, cut: float, reaches: np.ndarray
) -> None:
    """Fill ``reaches`` (k,) with how far the thing of a cluster reaches along each of NORMALS, m.

    What stands before the lidar along a normal, sees the lidar, however little of the rest is in sight. Along
    the other normals it may reach farther than its points: NaN. So it is near an end that is ``cut`` or more.
    """
    n, first, end = points.shape[0], int(cluster[FIRST]), int(cluster[END])
    for k in range(NORMALS.shape[0]):
        x, y = NORMALS[k]
        farthest, at = -math.inf, first
        for j in range(first, end):
            reach = x * points[j % n, 0] + y * points[j % n, 1]
            if reach > farthest:
                farthest, at = reach, j % n
        px, py = points[at]
        is_seen = x * pose[0] + y * pose[1] - farthest > GRAZING_SINE * math.hypot(px - pose[0], py - pose[1])
        for column, j in ((CUT_FIRST, first % n), (CUT_LAST, (end - 1) % n)):
            if cluster[column] >= cut and math.hypot(px - points[j, 0], py - points[j, 1]) < CUT_OFF_M:
                is_seen = False
        reaches[k] = farthest if is_seen else math.nan


@njit(cache=True)
def shift_of(reaches: np.ndarray, track: np.ndarray, shift: np.ndarray) -> int:
    """Fill ``shift`` (2,) with how far a thing is from its track; return how many known sides tell it.

    Outliers count little. Along an axis that no side tells, it is where it was predicted.
    """
    shift[:] = 0.0
    known = 0
    for _ in range(3):
        a, b, c, right_x, right_y, known = SIDES_DAMPING, 0.0, SIDES_DAMPING, 0.0, 0.0, 0
        for k in range(NORMALS.shape[0]):
            x, y = NORMALS[k]
            off = reaches[k] - track[REACH + k] - x * track[X] - y * track[Y]
            if math.isnan(off):
                continue
            w = 1.0 / (1.0 + ((off - x * shift[0] - y * shift[1]) / SIDES_OUTLIER_M) ** 2)
            a, b, c = a + w * x * x, b + w * x * y, c + w * y * y
            right_x, right_y, known = right_x + w * off * x, right_y + w * off * y, known + 1
        determinant = a * c - b * b
        shift[0] = (c * right_x - b * right_y) / determinant
        shift[1] = (a * right_y - b * right_x) / determinant
    return known
