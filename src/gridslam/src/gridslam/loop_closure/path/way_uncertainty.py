"""How uncertain a node's pose is relative to every other: along the shortest way over steps and closures.

It is an upper bound of the uncertainty in the whole graph: M. Bosse et al., "An Atlas framework for scalable
mapping" (ICRA 2003).
"""

from __future__ import annotations

from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.kernels.pose_graph import shortest_ways
from gridslam.loop_closure.edges import Match
from gridslam.loop_closure.path.measured_path import MeasuredPath

CLOSURE_WAY_M = 0.1  # length of an edge over a closure, in metres of path


def way_covariances(
    path: MeasuredPath,
    step_covariances: np.ndarray,
    closures: Sequence[Match],
    node: int,
    drift_share: float,
) -> np.ndarray:
    """Return the covariances (k, 3, 3) of a node's pose relative to every other, in the node's own frame.

    Args:
        path: k nodes.
        step_covariances: (k - 1, 3, 3) of its steps.
        closures: join nodes as steps do.
        node: the one whose pose is described.
        drift_share: systematic error as a share of the way.
    """
    count = len(path)
    ends = [(i, i + 1) for i in range(count - 1)] + [(c.older, c.newer) for c in closures]
    # Rows side by side in memory: for others numba would compile the kernel again, in flight.
    older, newer = np.ascontiguousarray(np.array(ends, int).reshape(-1, 2).T)
    lengths = np.concatenate([np.diff(path.way_m) + 1e-3, np.full(len(closures), CLOSURE_WAY_M)])
    length_m, before, edges = shortest_ways(count, older, newer, lengths, node)
    of_edges = np.concatenate([step_covariances, np.reshape([c.covariance for c in closures], (-1, 3, 3))])
    covariances, others = np.zeros((count, 3, 3)), np.arange(count) != node
    frames = se2.between(path.poses[node], path.poses[newer[edges[others]]])
    covariances[others] = carried(of_edges[edges[others]], frames)
    # Each round doubles the number of edges that are added up.
    while (before != node).any():
        covariances += covariances[before]
        before = before[before]
    systematic = (drift_share * length_m) ** 2
    covariances[:, 0, 0] += systematic
    covariances[:, 1, 1] += systematic
    return covariances


def carried(covariances: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """Return covariances (n, 3, 3) of small errors of frames at poses (n, 3), as errors of the common frame.

    This is the adjoint map of SE(2): an error of a frame's heading becomes a shift, in proportion to the
    distance.
    """
    adjoint = np.zeros((len(frames), 3, 3))
    cos, sin = np.cos(frames[:, 2]), np.sin(frames[:, 2])
    adjoint[:, 0, 0], adjoint[:, 0, 1] = cos, -sin
    adjoint[:, 1, 0], adjoint[:, 1, 1] = sin, cos
    adjoint[:, 0, 2], adjoint[:, 1, 2] = frames[:, 1], -frames[:, 0]
    adjoint[:, 2, 2] = 1.0
    return adjoint @ covariances @ adjoint.transpose(0, 2, 1)
