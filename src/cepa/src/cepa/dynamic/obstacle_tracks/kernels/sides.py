"""The sides of things: how far they reach, and how far they are from their tracks."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.obstacle_tracks import (
    CUT_OFF_M,
    GRAZING_SINE,
    SIDES_AGREE,
    SIDES_DAMPING,
    SIDES_NEW_M,
    SIDES_OUTLIER_M,
)
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
def shift_of(reaches: np.ndarray, track: np.ndarray, shift: np.ndarray, are_new: np.ndarray) -> int:
    """Fill ``shift`` (2,) with how far a thing is from its track; return how many known sides tell it.

    Outliers count little. Along an axis that no side tells, it is where it was predicted. Fills ``are_new``
    (k,) with the sides that tell nothing, because they contradict those that agree: a thing has come into
    view in parts, or two things have met.
    """
    off = np.empty(NORMALS.shape[0])
    for k in range(off.size):
        x, y = NORMALS[k]
        off[k] = reaches[k] - track[REACH + k] - x * track[X] - y * track[Y]
    shift[:], unseen, agree = 0.0, np.isnan(off), 0
    for _ in range(3):
        _fit(off, unseen, shift)
    for k in range(off.size):
        rest = abs(off[k] - NORMALS[k, 0] * shift[0] - NORMALS[k, 1] * shift[1])
        agree += rest < SIDES_OUTLIER_M
        are_new[k] = rest > SIDES_NEW_M
    if agree < SIDES_AGREE:
        are_new[:] = False
    if are_new.any():
        _fit(off, unseen | are_new, shift)
    return off.size - unseen.sum() - are_new.sum()


@njit(cache=True)
def _fit(off: np.ndarray, left_out: np.ndarray, shift: np.ndarray) -> None:
    """Improve ``shift`` (2,) by damped least squares over the sides' ``off`` (k,), m, but those left out."""
    a, b, c, right_x, right_y = SIDES_DAMPING, 0.0, SIDES_DAMPING, 0.0, 0.0
    for k in range(off.size):
        if left_out[k]:
            continue
        x, y = NORMALS[k]
        w = 1.0 / (1.0 + ((off[k] - x * shift[0] - y * shift[1]) / SIDES_OUTLIER_M) ** 2)
        a, b, c = a + w * x * x, b + w * x * y, c + w * y * y
        right_x, right_y = right_x + w * off[k] * x, right_y + w * off[k] * y
    determinant = a * c - b * b
    shift[0] = (c * right_x - b * right_y) / determinant
    shift[1] = (a * right_y - b * right_x) / determinant
