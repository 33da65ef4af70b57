"""The parts of a path whose places to each other odometry alone tells."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from gridslam.loop_closure.edges import Edge


def loose_parts(open_nodes: Sequence[int], edges: Sequence[Edge], nodes: int) -> list[int]:
    """Return the first node of each part of a path, but the first, that nothing joins with another.

    A part begins at each node to which no scan measures the step. Links and closures join parts.

    Args:
        open_nodes: these nodes; each may be there twice.
        edges: links and closures.
        nodes: number of all nodes.
    """
    from scipy.sparse import coo_array  # 25 MB, and most paths have no open step
    from scipy.sparse.csgraph import connected_components

    begins = np.unique([0, *(node for node in open_nodes if 0 < node < nodes)])
    ends = np.array([(edge.older, edge.newer) for edge in edges], int).reshape(-1, 2)
    older, newer = np.searchsorted(begins, ends, side="right").T - 1
    graph = coo_array((np.ones(len(ends)), (older, newer)), shape=(len(begins), len(begins)))
    _, joined = connected_components(graph, directed=False)
    _, first = np.unique(joined, return_index=True)
    return begins[np.sort(first)[1:]].tolist()
