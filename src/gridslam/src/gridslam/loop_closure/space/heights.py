"""Stage 5 in the vertical: the heights that fit odometry's climbs and those of the closures best.

Roll and pitch are the IMU's, so a climb depends on no other coordinate. The pose graph of x, y, z and yaw
falls apart into that of the plane (`path.pose_graph`) and this one, whose equations are linear.
"""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from gridslam.kernels.pose_graph import shortest_ways
from gridslam.loop_closure.edges import Match
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.measured_path import MeasuredPath
from gridslam.loop_closure.path.pose_graph import FIRST_SCALE, ROBUST_SCALE
from gridslam.loop_closure.path.way_uncertainty import CLOSURE_WAY_M

STEP_SIGMA_MIN_M = 0.002
STEPS_MAX, STILL_M = 30, 1e-5
"""Of a search: it ends after so many steps, or when no height moves by more than this."""


def has_climb(match: Match) -> bool:
    """Return whether a match has measured the climb."""
    return math.isfinite(match.climb_m)


def step_variances_m2(path: MeasuredPath, parameters: LoopClosureParameters) -> np.ndarray:
    """Return the variances (k - 1,) of the path's climbs by odometry, m2."""
    return parameters.climb_m_per_sqrt_m**2 * np.diff(path.way_in_space_m) + STEP_SIGMA_MIN_M**2


def climb_sigmas_m(
    path: MeasuredPath, closures: Sequence[Match], node: int, parameters: LoopClosureParameters
) -> np.ndarray:
    """Return the standard deviations (k,) of the climbs along the path from every node to one of them, m.

    The way is the shortest one over steps and closures, as in `way_uncertainty`. As in the plane, odometry
    may also err by a share of the way, always to the same side.
    """
    measured = [closure for closure in closures if has_climb(closure)]
    steps = np.arange(len(path) - 1)
    older = np.concatenate([steps, np.array([each.older for each in measured], int)])
    newer = np.concatenate([steps + 1, np.array([each.newer for each in measured], int)])
    lengths_m = np.concatenate([np.diff(path.way_in_space_m) + 1e-3, np.full(len(measured), CLOSURE_WAY_M)])
    ways_m, _, _ = shortest_ways(len(path), older, newer, lengths_m, node)
    variances_m2 = parameters.climb_m_per_sqrt_m**2 * ways_m + (parameters.drift_share * ways_m) ** 2
    return np.sqrt(variances_m2)


def fitted_heights(
    path: MeasuredPath, closures: Sequence[Match], parameters: LoopClosureParameters
) -> np.ndarray:
    """Return the nodes' heights (k,) that fit the climbs best. The first one stays fixed.

    A closure loses weight when the others contradict it, as in `pose_graph.optimise`. Heights that are not
    known stay as they are.
    """
    measured = [closure for closure in closures if has_climb(closure)]
    if not measured or not np.isfinite(path.heights_m).all():
        return path.heights_m
    older, newer = (np.array([getattr(each, end) for each in measured]) for end in ("older", "newer"))
    climbs_m = np.array([each.climb_m for each in measured])
    sigmas_m = np.array([each.climb_sigma_m for each in measured])
    heights_m = path.heights_m
    for scale in (FIRST_SCALE, ROBUST_SCALE):
        for _ in range(STEPS_MAX):
            off = (heights_m[newer] - heights_m[older] - climbs_m) / sigmas_m
            weights = 1.0 / (sigmas_m**2 * (1.0 + (off / scale) ** 2))  # Cauchy
            before_m = heights_m
            heights_m = _solved(path, parameters, (older, newer, climbs_m, weights))
            if np.abs(heights_m - before_m).max() < STILL_M:
                break
    return heights_m


def _solved(
    path: MeasuredPath,
    parameters: LoopClosureParameters,
    closures: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray],
) -> np.ndarray:
    """Return the heights (k,) that fit the steps and weighed closures: nodes, climbs and weights (m,)."""
    from scipy.sparse import csc_matrix  # 25 MB, and level scans alone measure no climb
    from scipy.sparse.linalg import spsolve

    nodes = np.arange(len(path))
    older = np.concatenate([nodes[:-1], closures[0]])
    newer = np.concatenate([nodes[1:], closures[1]])
    climbs_m = np.concatenate([path.climbs_m, closures[2]])
    weights = np.concatenate([1.0 / step_variances_m2(path, parameters), closures[3]])
    rows = np.concatenate([older, newer, older, newer])
    columns = np.concatenate([older, newer, newer, older])
    values = np.concatenate([weights, weights, -weights, -weights])
    matrix = csc_matrix((values, (rows, columns)), shape=(len(path), len(path)))
    pull = np.zeros(len(path))
    np.add.at(pull, newer, weights * climbs_m)
    np.subtract.at(pull, older, weights * climbs_m)
    first_m = path.heights_m[0]
    pull -= matrix[:, [0]].toarray()[:, 0] * first_m
    free = spsolve(matrix[1:, 1:].tocsc(), pull[1:])
    return np.concatenate([[first_m], np.atleast_1d(free)])
