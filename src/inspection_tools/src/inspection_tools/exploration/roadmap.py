"""Places on a lattice in what the UAV may fly through, and the shortest ways to them from where it is."""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from inspection_tools.exploration.kernels.lattice import open_edges
from inspection_tools.planning.kernels.pulling import leg_cost
from inspection_tools.planning.space import Space

LINK_M = 1.5
"""The UAV joins the lattice at places nearer than this, beyond the lattice's own spacing."""


class Roadmap:
    """The lattice and the ways.

    Attributes:
        nodes: (n, 3) z, y, x of voxels that keep the clearance. ways_m: (n,) length of the shortest way from
            the UAV; infinite: none is known. clearances: (n,) squared, in voxels.
    """

    def __init__(self, space: Space, place_m: np.ndarray, spacing: int):
        self._space = space
        part = space.squares[::spacing, ::spacing, ::spacing]
        is_node = part >= space.need
        self.nodes = np.argwhere(is_node) * spacing
        self.clearances = part[is_node]
        numbers = np.full(is_node.shape, -1, np.int64)
        numbers[is_node] = np.arange(len(self.nodes))
        heads, tails, lengths = open_edges(space.squares, space.need, numbers, spacing)
        linked, links = self._links(place_m, spacing)
        count = len(self.nodes)
        rows = np.concatenate((heads, np.full(len(linked), count)))
        columns = np.concatenate((tails, linked))
        weights = np.concatenate((lengths, links))
        graph = csr_matrix((weights, (rows, columns)), shape=(count + 1, count + 1))
        ways, came = dijkstra(graph, directed=False, indices=count, return_predecessors=True)
        self.ways_m = ways[:-1] * space.grid.resolution_m
        self._came = came

    def _links(self, place_m: np.ndarray, spacing: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the nodes that the UAV can fly to straight, and how far they are, in voxels."""
        space = self._space
        here = space.inner(place_m)
        off = np.linalg.norm(self.nodes + 0.5 - here, axis=1)
        near = np.flatnonzero(off <= LINK_M / space.grid.resolution_m + spacing)
        legs = (leg_cost(space.squares, space.need, space.factors, here, self.nodes[n] + 0.5) for n in near)
        is_open = np.array([math.isfinite(leg) for leg in legs], bool)
        return near[is_open], off[near[is_open]] + 1e-9

    @property
    def reachable(self) -> np.ndarray:
        """(k,) numbers of the nodes that a way leads to."""
        return np.flatnonzero(np.isfinite(self.ways_m))

    def place_m(self, node: int) -> np.ndarray:
        """Return where a node is: x, y, z in the map's frame."""
        centre: np.ndarray = self._space.grid.centres_m(self.nodes[node : node + 1])[0]
        return centre
