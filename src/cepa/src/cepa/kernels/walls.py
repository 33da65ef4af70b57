"""Points of the walls of a box near a place."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit


@njit(cache=True)
def walls_near(
    low: np.ndarray, high: np.ndarray, place: np.ndarray, reach: np.ndarray, step: float
) -> np.ndarray:
    """Return points (n, 3), m, of a box's faces within ``reach`` (3,) of a place (3,), which is not inside.

    low, high (3,): the box's corners, m. The points are at most ``step`` apart, along the faces' edges. Of
    three axes the last one runs fastest.
    """
    near_low, near_high = np.maximum(low, place - reach), np.minimum(high, place + reach)
    counts = np.empty(3, np.int64)
    for axis in range(3):
        if near_low[axis] > near_high[axis]:
            return np.empty((0, 3))
        counts[axis] = math.ceil((near_high[axis] - near_low[axis]) / step) + 1
    total, steps = 0, np.empty((3, counts.max()))
    for axis in range(3):
        on_face = int(low[axis] == near_low[axis]) + int(high[axis] == near_high[axis])
        total += on_face * (counts[0] * counts[1] * counts[2] // counts[axis])
        apart = (near_high[axis] - near_low[axis]) / max(1, counts[axis] - 1)
        for k in range(counts[axis]):
            steps[axis, k] = k * apart + near_low[axis]
        if counts[axis] > 1:
            steps[axis, counts[axis] - 1] = near_high[axis]
    points, found = np.empty((total, 3)), 0
    for axis in range(3):
        for is_high in range(2):
            end, near = (high[axis], near_high[axis]) if is_high else (low[axis], near_low[axis])
            if end == near:
                found = _fill_face(steps, counts, axis, end, points, found)
    return points


@njit(cache=True)
def _fill_face(
    steps: np.ndarray, counts: np.ndarray, axis: int, end: float, points: np.ndarray, found: int
) -> int:
    """Write the face at ``end`` of an axis behind the ``found`` points; return how many there are then."""
    most = counts.copy()
    most[axis] = 1
    for i in range(most[0]):
        for j in range(most[1]):
            for k in range(most[2]):
                points[found, 0], points[found, 1], points[found, 2] = steps[0, i], steps[1, j], steps[2, k]
                points[found, axis] = end
                found += 1
    return found
