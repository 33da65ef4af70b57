"""The path as a pose graph of steps, links and closures.

F. Dellaert and M. Kaess, "Factor Graphs for Robot Perception" (2017).
"""

from __future__ import annotations

import numpy as np

from gridslam import se2
from gridslam.kernels.least_squares import inverses
from gridslam.kernels.pose_graph import Edges as WeighedEdges
from gridslam.kernels.pose_graph import cost_of, optimise_graph
from gridslam.loop_closure.edges import Edges

ROBUST_SCALE = 2.0  # from this many standard deviations on, an edge loses weight (Cauchy)
FIRST_SCALE, FIRST_TOLERANCE = 20.0, 1e-3  # of the first of two searches, in which wrong steps still yield


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


def robust_cost(poses: np.ndarray, edges: Edges) -> float:
    """Return the cost of poses (k, 3): the sum over the edges, each with the robust kernel."""
    weighed = WeighedEdges(*edges[:3], inverses(edges.covariance))
    return float(cost_of(weighed, poses, ROBUST_SCALE))
