"""Shortest ways on a lattice in free space."""

from __future__ import annotations

import math

import numpy as np

from exploration.planning.kernels.heap import drop_first, push
from exploration.planning.kernels.neighbours import LENGTHS, STEPS
from kernel_cache.compiler import njit


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
    not looked at.

    Args:
        squares: squared clearances, voxels.
        need: squared clearance that a way keeps.
        is_even: over a straight edge between two voxels of some clearance, it falls by no more than the way.
        spacing: voxels between nodes.
        nodes: (n, 3) z, y, x, counted in nodes, where ways begin.
        lengths: (n,) of the way that leads there.
    """
    depth, height, width = squares.shape
    shape = (
        (depth + spacing - 1) // spacing,
        (height + spacing - 1) // spacing,
        (width + spacing - 1) // spacing,
    )
    at_nodes = squares[::spacing, ::spacing, ::spacing].copy()  # which a processor's cache holds
    found = np.full(shape, np.inf)
    flat = found.reshape(-1)
    keys, items = np.empty(1024, np.float64), np.empty(1024, np.int64)
    size, least = 0, 2.0 * math.sqrt(need) + 1e-9
    for n in range(len(nodes)):
        item = (nodes[n, 0] * shape[1] + nodes[n, 1]) * shape[2] + nodes[n, 2]
        if lengths[n] < flat[item]:
            flat[item] = lengths[n]
            if size == keys.size:
                keys, items = np.concatenate((keys, keys)), np.concatenate((items, items))
            push(keys, items, size, lengths[n], item)
            size += 1
    while size > 0:
        length, item = keys[0], items[0]
        size -= 1
        drop_first(keys, items, size)
        if length > flat[item]:
            continue
        x, y, z = item % shape[2], item // shape[2] % shape[1], item // (shape[1] * shape[2])
        clearance = math.sqrt(at_nodes[z, y, x])
        for k in range(26):
            c, b, a = z + STEPS[k, 0], y + STEPS[k, 1], x + STEPS[k, 2]
            if not (0 <= c < shape[0] and 0 <= b < shape[1] and 0 <= a < shape[2]):
                continue
            new = length + spacing * LENGTHS[k]
            other = (c * shape[1] + b) * shape[2] + a
            if new >= flat[other]:
                continue
            at_end = at_nodes[c, b, a]
            if at_end < need:
                continue
            # In an even space no clearance on the edge is less than half of this.
            surely = clearance + math.sqrt(at_end) - spacing * LENGTHS[k]
            if not ((is_even and surely >= least) or _is_edge(squares, need, spacing, (z, y, x), k)):
                continue
            flat[other] = new
            if size == keys.size:
                keys, items = np.concatenate((keys, keys)), np.concatenate((items, items))
            push(keys, items, size, new, other)
            size += 1
    return found


@njit(cache=True, nogil=True)
def _is_edge(squares: np.ndarray, need: int, spacing: int, node: tuple[int, int, int], k: int) -> bool:
    """Return whether every voxel from a node's to that of its neighbour `k` keeps the clearance."""
    z, y, x = node[0] * spacing, node[1] * spacing, node[2] * spacing
    for step in range(spacing, -1, -1):
        if squares[z + step * STEPS[k, 0], y + step * STEPS[k, 1], x + step * STEPS[k, 2]] < need:
            return False
    return True
