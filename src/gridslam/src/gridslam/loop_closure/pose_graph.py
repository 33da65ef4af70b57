"""The path as a pose graph of steps, links and closures, optimised by GTSAM.

F. Dellaert and M. Kaess, "Factor Graphs for Robot Perception" (2017). The uncertainty along the shortest
path between two nodes is an upper bound of their uncertainty in the whole graph: M. Bosse et al., "An Atlas
framework for scalable mapping" (ICRA 2003).
"""

from __future__ import annotations

from types import ModuleType
from typing import Any, Iterable, Sequence

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from gridslam import se2
from gridslam.errors import SlamError
from gridslam.loop_closure.chain import Chain
from gridslam.loop_closure.edge import Edge
from gridslam.loop_closure.match import Match

ROBUST_SCALE = 2.0  # from this many standard deviations on, an edge loses weight (Cauchy)
ANCHOR_SIGMA = 1e-6
CLOSURE_WAY_M = 0.1  # length of an edge over a closure, in metres of path


def optimise(
    start: np.ndarray,
    edges: Iterable[Edge | Match],
    factors: dict[Edge | Match, Any] | None = None,
    tolerance: float = 1e-5,
) -> np.ndarray:
    """Return the nodes' poses (k, 3) that fit the edges best. The first node stays fixed.

    Args:
        start: poses (k, 3) from which the search starts.
        edges: steps, links and closures. Each loses weight when the others contradict it.
        factors: GTSAM's of the edges of an earlier call, to save time. It gets those of this call.
        tolerance: the search ends when a step lowers the cost by less than this share.

    Raises:
        SlamError: GTSAM is not installed.
    """
    gtsam = import_gtsam()
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    fixed = gtsam.noiseModel.Isotropic.Sigma(3, ANCHOR_SIGMA)
    graph.add(gtsam.PriorFactorPose2(0, gtsam.Pose2(*start[0]), fixed))
    for node, pose in enumerate(start):
        values.insert(node, gtsam.Pose2(*pose))
    cauchy = gtsam.noiseModel.mEstimator.Cauchy.Create(ROBUST_SCALE)
    known = {} if factors is None else factors
    used = {}
    for edge in edges:
        if edge not in known:
            gaussian = gtsam.noiseModel.Gaussian.Covariance(edge.covariance)
            noise = gtsam.noiseModel.Robust.Create(cauchy, gaussian)
            measured = gtsam.Pose2(*edge.newer_in_older)
            known[edge] = gtsam.BetweenFactorPose2(edge.older, edge.newer, measured, noise)
        used[edge] = known[edge]
        graph.add(used[edge])
    known.clear()
    known.update(used)
    settings = gtsam.LevenbergMarquardtParams()
    settings.setRelativeErrorTol(tolerance)
    return gtsam.utilities.extractPose2(gtsam.LevenbergMarquardtOptimizer(graph, values, settings).optimize())


def import_gtsam() -> ModuleType:
    """Return the module gtsam, which loads slowly. Raises SlamError if it is not installed."""
    try:
        import gtsam
    except ImportError as error:
        raise SlamError(f"Loop closure needs gtsam: pip install -r requirements.txt ({error}).") from None
    return gtsam


class ShortestWays:
    """The shortest path from every node to one, over steps and closures, and the uncertainty along it."""

    def __init__(
        self,
        chain: Chain,
        closures: Sequence[Match],
        node: int,
        drift_share: float,
        steps: np.ndarray | None = None,
    ) -> None:
        """``steps``: covariances (k - 1, 3, 3) of the steps; None: those of the chain."""
        count = len(chain)
        ends = [(i, i + 1) for i in range(count - 1)] + [(c.older, c.newer) for c in closures]
        lengths = np.concatenate([np.diff(chain.way_m) + 1e-3, np.full(len(closures), CLOSURE_WAY_M)])
        rows, columns = np.array(ends, dtype=int).reshape(-1, 2).T
        # Keep one of two edges between the same nodes, because entries of a coo_matrix would add up.
        keys, first = np.unique(rows * count + columns, return_index=True)
        graph = coo_matrix((lengths[first], (rows[first], columns[first])), shape=(count, count))
        self.length_m, before = dijkstra(
            graph.tocsr(), directed=False, indices=node, return_predecessors=True
        )
        covariances = np.concatenate(
            [
                chain.covariances if steps is None else steps,
                np.reshape([c.covariance for c in closures], (-1, 3, 3)),
            ]
        )
        carried = carry(covariances[first], se2.between(chain.poses[node], chain.poses[columns[first]]))
        before[node], nodes = node, np.arange(count)
        edge = np.searchsorted(keys, np.minimum(nodes, before) * count + np.maximum(nodes, before))
        self.covariances = carried[np.minimum(edge, len(keys) - 1)]
        """(k, 3, 3) of the node's pose relative to every other, in the node's own frame."""
        self.covariances[node] = 0.0
        # Each round doubles the number of edges that are added up.
        while (before != node).any():
            self.covariances += self.covariances[before]
            before = before[before]
        systematic = (drift_share * self.length_m) ** 2
        self.covariances[:, 0, 0] += systematic
        self.covariances[:, 1, 1] += systematic


def carry(covariances: np.ndarray, frames: np.ndarray) -> np.ndarray:
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
