"""Parts of a path that odometry alone joins, on paths of ten nodes."""

import numpy as np
import pytest

from gridslam.loop_closure.edges import Edge
from gridslam.loop_closure.path.loose_parts import loose_parts


@pytest.mark.table(
    ("open_nodes", "joined", "parts"),
    [
        ([], [], []),
        ([4], [], [4]),
        ([4, 4], [(1, 2), (5, 6)], [4]),  # links inside a part join nothing
        ([4], [(2, 7)], []),
        ([4, 7], [(2, 8)], [4]),  # the part in between stays loose
        ([4, 7], [(2, 5), (6, 9)], []),
        ([4, 7], [(5, 8)], [4]),  # two of three parts are one, at another place
        ([0, 10], [], []),  # no steps of this path
    ],
)
def test_parts_are_joined_by_links_and_closures(open_nodes, joined, parts):
    edges = [Edge(older, newer, np.zeros(3), np.eye(3)) for older, newer in joined]
    assert loose_parts(open_nodes, edges, 10) == parts
