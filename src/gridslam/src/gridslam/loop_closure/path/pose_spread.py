"""How uncertain the newest pose is: in the map, and since a place was recognised."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from gridslam import se2
from gridslam.kernels.pose_graph import covariance_of
from gridslam.loop_closure.edges import Edges, Match
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.error_share import ErrorShares, scaled
from gridslam.loop_closure.path.measured_path import MeasuredPath, odometry_covariances
from gridslam.loop_closure.path.way_uncertainty import way_covariances


class PoseSpread(NamedTuple):
    """How uncertain the path's newest pose is."""

    since_recognised_m: float
    """Greatest standard deviation of its place, seen from the node at which a place was recognised last."""
    in_map: np.ndarray
    """(3, 3) covariance of x, y and yaw in the map, which begins at the first node: m2, m rad, rad2."""
    error_share: float = 1.0
    """How large the place's error in the map is usually, as a share of what the covariance tells."""

    @property
    def in_map_m(self) -> float:
        """Greatest standard deviation of the place in the map."""
        return widest_m(self.in_map)


NO_SPREAD = PoseSpread(0.0, np.zeros((3, 3)))


def pose_spread(
    path: MeasuredPath,
    step_covariances: np.ndarray,
    closures: Sequence[Match],
    recognised: int,
    systematic_m: np.ndarray | None = None,
) -> PoseSpread:
    """Return how uncertain the newest pose of a path is, by steps and closures.

    Since a place was recognised, the shortest way over them counts: an upper bound. In the map all of them
    count together, for many loops hold a building.

    Args:
        path: k nodes, at least one.
        step_covariances: (k - 1, 3, 3) of its steps.
        closures: those that count.
        recognised: the newest node at which a place was found again, and the path was right; 0: none.
        systematic_m: (k - 1, 2) x and y of each step's error in the map that is the same for all of them; see
            `systematic_errors`. Such errors add up, and their squares do not. None: there are none.
    """
    newest = len(path) - 1
    # drift_share is an allowance for searches; without it these deviations are upper bounds already
    since = way_covariances(path, step_covariances, closures, newest, drift_share=0.0)[recognised]
    if systematic_m is not None:
        off_m = se2.transform((0.0, 0.0, -path.poses[newest, 2]), systematic_m[recognised:].sum(axis=0)[None])
        since[:2, :2] += off_m.T @ off_m
    cos, sin = math.cos(path.poses[newest, 2]), math.sin(path.poses[newest, 2])
    turn = np.array(((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)))
    in_map = turn @ _in_map(path, step_covariances, closures) @ turn.T
    return PoseSpread(widest_m(since), in_map)


def systematic_errors(
    path: MeasuredPath, step_covariances: np.ndarray, by_odometry: np.ndarray, share_off: float
) -> np.ndarray:
    """Return x and y (k - 1, 2) of the steps' errors in the map if odometry's metre is off by a share.

    Scans correct a step as far as they measure it. What they leave of odometry's variance, as all of it
    along a bare corridor, they leave of this error, too.

    Args:
        path: k nodes.
        step_covariances: (k - 1, 3, 3) of its steps, with scans.
        by_odometry: (k - 1, 3, 3) of the same steps by odometry alone; x and y are alike.
        share_off: by which odometry's ways may be wrong.
    """
    left, directions = np.linalg.eigh(step_covariances[:, :2, :2] / by_odometry[:, :1, :1])
    left = np.clip(left, 0.0, 1.0)
    ways_m = np.diff(path.poses[:, :2], axis=0)
    yaw = path.poses[1:, 2]
    turned = np.stack([np.stack([np.cos(yaw), -np.sin(yaw)], 1), np.stack([np.sin(yaw), np.cos(yaw)], 1)], 1)
    directions = turned @ directions
    along_m = np.einsum("nij,ni->nj", directions, ways_m)
    return share_off * np.einsum("nij,nj->ni", directions, left * along_m)


def with_usual_errors(
    spread: PoseSpread,
    path: MeasuredPath,
    step_covariances: np.ndarray,
    closures: Sequence[Match],
    shares: ErrorShares,
    parameters: LoopClosureParameters,
) -> PoseSpread:
    """Return the spread with the share that errors of the usual size have of it.

    Args:
        spread: of these steps and closures.
        path: k nodes, at least one.
        step_covariances: (k - 1, 3, 3) of its steps.
        closures: those that count.
        shares: how large errors were so far.
        parameters: of odometry.
    """
    if spread.in_map_m == 0.0:
        return spread
    steps = scaled(step_covariances, odometry_covariances(path.steps, parameters), shares)
    usual_m = widest_m(_in_map(path, steps, closures, shares.scans))
    return spread._replace(error_share=usual_m / spread.in_map_m)


def _in_map(
    path: MeasuredPath, step_covariances: np.ndarray, closures: Sequence[Match], closure_share: float = 1.0
) -> np.ndarray:
    """Return the covariance (3, 3) of the newest node in the first one, in the newest one's frame."""
    found, nodes = Edges.of(closures), np.arange(len(path))
    older = np.concatenate([nodes[:-1], found.older])
    newer = np.concatenate([nodes[1:], found.newer])
    covariances = np.concatenate([step_covariances, closure_share**2 * found.covariance])
    # as the path has them: what contradicts it, the correction has weighed already
    measured = se2.between(path.poses[older], path.poses[newer])
    return covariance_of(path.poses, older, newer, measured, covariances, len(path) - 1)


def widest_m(covariance: np.ndarray) -> float:
    """Return the greatest standard deviation of the place, of a pose's covariance (3, 3)."""
    return math.sqrt(max(0.0, float(np.linalg.eigvalsh(covariance[:2, :2])[-1])))
