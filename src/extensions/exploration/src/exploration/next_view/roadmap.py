"""Places on a lattice in what the UAV may fly through, and how long the ways to them are."""

from __future__ import annotations

import math

import numpy as np

from exploration.next_view.kernels.lattice import lattice_ways, most_room
from exploration.planning.kernels.pulling import leg_cost
from exploration.planning.space import Space

APART_M = 1.2
"""Between places to look from: near ones show the same."""
LINK_M = 1.5
"""The UAV joins the lattice at places nearer than this, beyond the lattice's own spacing."""


class Roadmap:
    """The places of the lattice that a way leads to.

    Attributes:
        nodes: (n, 3) z, y, x of voxels that keep the clearance. ways_m: (n,) length of the shortest way from
            the UAV. clearances: (n,) squared, in voxels. spacing: voxels between places of the lattice.
    """

    def __init__(self, space: Space, place_m: np.ndarray, spacing: int):
        self._space, self.spacing = space, spacing
        given = space.squares, space.need, space.is_even
        ways = lattice_ways(*given, spacing, *self._links(place_m, spacing))
        is_reached = np.isfinite(ways)
        self.nodes = np.argwhere(is_reached) * spacing
        self.ways_m = ways[is_reached] * space.grid.resolution_m
        self.clearances = space.squares[tuple(self.nodes.T)].astype(np.int64)

    def _links(self, place_m: np.ndarray, spacing: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the nodes, in the lattice, that the UAV can fly to straight, and how far they are."""
        space = self._space
        here = space.inner(place_m)
        reach = LINK_M / space.grid.resolution_m + spacing
        shape = -(-np.array(space.squares.shape) // spacing)
        low = np.clip(np.floor((here - reach) / spacing).astype(np.int64), 0, shape)
        high = np.clip(np.ceil((here + reach) / spacing).astype(np.int64) + 1, 0, shape)
        nodes = np.argwhere(np.ones(np.maximum(high - low, 0), bool)) + low
        centres = nodes * spacing + 0.5
        off = np.linalg.norm(centres - here, axis=1)
        is_near = (off <= reach) & (space.squares[tuple((nodes * spacing).T)] >= space.need)
        nodes, centres, off = nodes[is_near], centres[is_near], off[is_near]
        legs = [leg_cost(space.squares, space.need, space.factors, here, centre) for centre in centres]
        is_open = np.array([math.isfinite(leg) for leg in legs], bool)
        return nodes[is_open], off[is_open]

    def ways_from(self, node: int) -> np.ndarray:
        """Return (n,) the length of the shortest way from a node to each, m."""
        space, begin = self._space, self.nodes[node : node + 1] // self.spacing
        ways = lattice_ways(space.squares, space.need, space.is_even, self.spacing, begin, np.zeros(1))
        lengths_m: np.ndarray = ways[tuple((self.nodes // self.spacing).T)] * space.grid.resolution_m
        return lengths_m

    def spread(self, nodes: np.ndarray) -> np.ndarray:
        """Return of nodes (k,) one in each cube of the side `APART_M`: the one with the most room."""
        if not len(nodes):
            return nodes
        side = max(1, round(APART_M / self._space.grid.resolution_m))
        spread: np.ndarray = nodes[most_room(self.nodes[nodes], self.clearances[nodes], side)]
        return spread

    def ends_of_columns(self) -> np.ndarray:
        """Return the nodes (k,) without a node next above, or without one next below."""
        height, depth_width = self.nodes[:, 0], self.nodes[:, 1:]
        size = self.nodes.max(axis=0) + 1
        column = depth_width[:, 0] * size[2] + depth_width[:, 1]
        order = np.lexsort((height, column))
        apart = (np.diff(column[order]) != 0) | (np.diff(height[order]) != self.spacing)
        is_end = np.concatenate(([True], apart)) | np.concatenate((apart, [True]))
        return order[is_end]

    def nearest(self, place_m: np.ndarray) -> int:
        """Return the node that is nearest to a place (x, y, z)."""
        return int(np.argmin(np.linalg.norm(self._space.grid.centres_m(self.nodes) - place_m, axis=1)))

    def place_m(self, node: int) -> np.ndarray:
        """Return where a node is: x, y, z in the map's frame."""
        centre: np.ndarray = self._space.grid.centres_m(self.nodes[node : node + 1])[0]
        return centre
