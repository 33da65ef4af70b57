"""Shortest ways on a lattice in free space."""

from __future__ import annotations

import math

import numpy as np

from exploration.planning.kernels.neighbours import LENGTHS, STEPS
from kernel_cache.compiler import njit

NARROWER, AHEAD = 0.99, 4
"""Breadth of a bucket, in shortest edges. The longest edge leads fewer buckets ahead."""


@njit(cache=True, nogil=True)
def lattice_ways(
    squares: np.ndarray,
    need: int,
    is_even: bool,
    spacing: int,
    nodes: np.ndarray,
    lengths: np.ndarray,
) -> np.ndarray:
    """Return (d, h, w) the length of the shortest way to each node, voxels; infinite: there is none.

    A node is at every so many voxels along each axis. Those that touch are joined if every voxel of the edge
    keeps the clearance (Dijkstra, 1959). Where the clearances of both ends tell that, the voxels between are
    not looked at. Nodes wait in buckets narrower than the shortest edge, so that no node of a bucket shortens
    the way to another one of it (Dial, 1969): their order does not matter.

    Args:
        squares: squared clearances, voxels.
        need: squared clearance that a way keeps.
        is_even: over a straight edge between two voxels of some clearance, it falls by no more than the way.
        spacing: voxels between nodes.
        nodes: (n, 3) z, y, x, counted in nodes, where ways begin.
        lengths: (n,) of the way that leads there.
    """
    shape = (
        (squares.shape[0] + spacing - 1) // spacing,
        (squares.shape[1] + spacing - 1) // spacing,
        (squares.shape[2] + spacing - 1) // spacing,
    )
    # With a layer around it that nothing leads through, so that each node has 26 neighbours.
    found = np.full((shape[0] + 2, shape[1] + 2, shape[2] + 2), np.inf)
    roots = np.full(found.shape, -1.0)  # clearances, voxels; -1: not kept
    for z, y, x in np.ndindex(shape):
        square = squares[z * spacing, y * spacing, x * spacing]
        if square >= need:
            roots[z + 1, y + 1, x + 1] = math.sqrt(square)
    flat, clearances = found.reshape(-1), roots.reshape(-1)
    row, layer = found.shape[2], found.shape[1] * found.shape[2]
    offsets, edges = np.empty(26, np.int64), np.empty(26)
    for k in range(26):
        offsets[k] = STEPS[k, 0] * layer + STEPS[k, 1] * row + STEPS[k, 2]
        edges[k] = spacing * LENGTHS[k]
    # Of all entries: node, length, and the next entry of its bucket.
    items, keys, nexts = np.empty(1024, np.int64), np.empty(1024, np.float64), np.empty(1024, np.int64)
    wide = NARROWER * spacing
    heads = np.full(math.ceil(lengths.max() / wide) + AHEAD if len(lengths) else AHEAD, -1, np.int64)
    size, waiting, bucket, least = 0, 0, 0, 2.0 * math.sqrt(need) + 1e-9
    for n in range(len(nodes)):
        item = (nodes[n, 0] + 1) * layer + (nodes[n, 1] + 1) * row + nodes[n, 2] + 1
        if lengths[n] < flat[item]:
            flat[item] = lengths[n]
            if size == keys.size:
                items, keys, nexts = _doubled(items), _doubled(keys), _doubled(nexts)
            _put(items, keys, nexts, heads, size, item, lengths[n], wide)
            size, waiting = size + 1, waiting + 1
    while waiting > 0:
        entry = heads[bucket % len(heads)]
        if entry < 0:
            bucket += 1
            continue
        heads[bucket % len(heads)] = nexts[entry]
        waiting -= 1
        length, item = keys[entry], items[entry]
        if length > flat[item]:
            continue
        for k in range(26):
            other, new = item + offsets[k], length + edges[k]
            if new >= flat[other] or clearances[other] < 0.0:
                continue
            # In an even space no clearance on the edge is less than half of this.
            surely = max(clearances[item], 0.0) + clearances[other] - edges[k]
            if not (is_even and surely >= least):
                node = item // layer - 1, item // row % found.shape[1] - 1, item % row - 1
                if not _is_edge(squares, need, spacing, node, k):
                    continue
            flat[other] = new
            if size == keys.size:
                items, keys, nexts = _doubled(items), _doubled(keys), _doubled(nexts)
            _put(items, keys, nexts, heads, size, other, new, wide)
            size, waiting = size + 1, waiting + 1
    return found[1:-1, 1:-1, 1:-1].copy()


@njit(cache=True, nogil=True)
def _doubled(values: np.ndarray) -> np.ndarray:
    return np.concatenate((values, values))


@njit(cache=True, nogil=True)
def _put(
    items: np.ndarray,
    keys: np.ndarray,
    nexts: np.ndarray,
    heads: np.ndarray,
    entry: int,
    item: int,
    length: float,
    wide: float,
) -> None:
    """Put a node into the bucket of its length."""
    at = int(length / wide) % len(heads)
    items[entry], keys[entry], nexts[entry] = item, length, heads[at]
    heads[at] = entry


@njit(cache=True, nogil=True)
def _is_edge(squares: np.ndarray, need: int, spacing: int, node: tuple[int, int, int], k: int) -> bool:
    """Return whether every voxel from a node's to that of its neighbour `k` keeps the clearance."""
    z, y, x = node[0] * spacing, node[1] * spacing, node[2] * spacing
    for step in range(spacing, -1, -1):
        if squares[z + step * STEPS[k, 0], y + step * STEPS[k, 1], x + step * STEPS[k, 2]] < need:
            return False
    return True


@njit(cache=True, nogil=True)
def most_room(places: np.ndarray, clearances: np.ndarray, side: int) -> np.ndarray:
    """Return of places (n, 3) that of the greatest clearance (n,) in each cube, the first one of equals.

    places: z, y, x, from 0 on. side: of the cubes. The cubes ascend, z first.
    """
    size = np.zeros(3, np.int64)
    for n in range(len(places)):
        for axis in range(3):
            size[axis] = max(size[axis], places[n, axis] // side + 1)
    best = np.full(size[0] * size[1] * size[2], -1, np.int64)
    for n in range(len(places)):
        z, y, x = places[n, 0] // side, places[n, 1] // side, places[n, 2] // side
        cube = (z * size[1] + y) * size[2] + x
        if best[cube] < 0 or clearances[n] > clearances[best[cube]]:
            best[cube] = n
    return best[best >= 0]
