"""What the kernels of correlation compute, slowly and obviously; the tests hold the kernels to it."""

from __future__ import annotations

import itertools
import math

import numpy as np

from gridslam.kernels.correlation import CLASHES, FITS
from gridslam.loop_closure.local_maps.local_map import LocalMap


def score(reference: LocalMap, query: LocalMap, pose, overlap_min: float) -> float:
    """Return the share of comparisons that agree when the query's anchor stands there in the reference."""
    fits, clashes = _look_up(reference, _moved(query.surface.points_xy_m, pose))
    x, y, yaw = pose
    back = _moved(reference.surface.points_xy_m - (x, y), (0.0, 0.0, -yaw))
    _, clashes_back = _look_up(query, back)
    least = max(1.0, overlap_min * len(query.surface.points_xy_m))
    return fits / max(fits + clashes + clashes_back, least)


def best_score(
    reference,
    query,
    window,
    angles,
    overlap_min: float,
    apart_from=None,
    distance_m: float = 0.0,
    is_allowed=None,
):
    """Try every shift and angle of a window; return the best score and its pose.

    Poses less than `distance_m` from `apart_from` (x, y) are left out, and those that are not allowed.
    """
    cell = reference.resolution_m
    half = math.ceil(window.reach_m / cell)
    best = (-1.0, None)
    for dy, dx, angle in itertools.product(range(-half, half + 1), range(-half, half + 1), angles):
        x, y = window.predicted[0] + dx * cell, window.predicted[1] + dy * cell
        if apart_from is not None and math.dist((x, y), apart_from) < distance_m:
            continue
        if is_allowed is not None and not is_allowed(np.array([x, y, angle])):
            continue
        best = max(best, (score(reference, query, (x, y, angle), overlap_min), (x, y, angle)))
    return best


def crossed_cells(lidar_xy, end_xy, hit: bool) -> set[tuple[int, int]]:
    """Return the cells (x, y) at whole steps of one cell from the lidar on; before a hit, two less."""
    length = math.dist(lidar_xy, end_xy)
    count = int(length - 2.0 if hit else length) + 1
    parts = (step / length for step in range(count))
    return {tuple(math.floor(a + (b - a) * part) for a, b in zip(lidar_xy, end_xy)) for part in parts}


def _moved(points: np.ndarray, pose) -> np.ndarray:
    x, y, yaw = pose
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    return points @ turn.T + (x, y)


def _look_up(local_map: LocalMap, points: np.ndarray) -> tuple[float, float]:
    """Sum what the table holds at each point, FITS and CLASHES; beyond it nothing is known."""
    height, width = local_map.table.shape[:2]
    x, y = np.floor((points - local_map.origin_xy_m) / local_map.resolution_m).astype(int).T
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    values = local_map.table[y[inside], x[inside]] / 255.0
    return values[:, FITS].sum(), values[:, CLASHES].sum()
