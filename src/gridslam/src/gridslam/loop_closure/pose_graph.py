"""The path as a pose graph of steps, links and closures, and what it leaves uncertain.

F. Dellaert and M. Kaess, "Factor Graphs for Robot Perception" (2017). The uncertainty along the shortest
path between two nodes is an upper bound of their uncertainty in the whole graph: M. Bosse et al., "An Atlas
framework for scalable mapping" (ICRA 2003).
"""

from __future__ import annotations

from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.kernels.pose_graph import optimise_graph, shortest_ways
from gridslam.loop_closure.chain import Chain
from gridslam.loop_closure.edge import Edges, Match

ROBUST_SCALE = 2.0  # from this many standard deviations on, an edge loses weight (Cauchy)
FIRST_SCALE, FIRST_TOLERANCE = 20.0, 1e-3  # of the first of two searches, in which wrong steps still yield
CLOSURE_WAY_M = 0.1  # length of an edge over a closure, in metres of path


def optimise(start: np.ndarray, edges: Edges, tolerance: float = 1e-5, is_far: bool = False) -> np.ndarray:
    """Return the nodes' poses (k, 3) that fit the edges best. The first node stays fixed.

    Where the start is wrong by many standard deviations, the edges that say so have hardly any weight. So a
    first search, under a wide kernel, may go before (H. Yang et al., "Graduated non-convexity for robust
    spatial perception", 2020).

    Args:
        start: poses (k, 3) from which the search starts.
        edges: steps, links and closures. Each loses weight when the others contradict it.
        tolerance: the search ends when a step lowers the cost by less than this share.
        is_far: the start may be wrong by many standard deviations.
    """
    poses = np.array(start, float)
    searches = [(FIRST_SCALE, FIRST_TOLERANCE)] * is_far + [(ROBUST_SCALE, tolerance)]
    optimise_graph(poses, *edges, np.array(searches))
    poses[:, 2] = se2.wrap(poses[:, 2])
    return poses


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
        # Rows side by side in memory: for others numba would compile the kernel again, in flight.
        older, newer = np.ascontiguousarray(np.array(ends, int).reshape(-1, 2).T)
        lengths = np.concatenate([np.diff(chain.way_m) + 1e-3, np.full(len(closures), CLOSURE_WAY_M)])
        self.length_m, before, edges = shortest_ways(count, older, newer, lengths, node)
        covariances = np.concatenate(
            [
                chain.covariances if steps is None else steps,
                np.reshape([c.covariance for c in closures], (-1, 3, 3)),
            ]
        )
        self.covariances = np.zeros((count, 3, 3))
        """(k, 3, 3) of the node's pose relative to every other, in the node's own frame."""
        others = np.arange(count) != node
        frames = se2.between(chain.poses[node], chain.poses[newer[edges[others]]])
        self.covariances[others] = carry(covariances[edges[others]], frames)
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
