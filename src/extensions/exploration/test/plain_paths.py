"""Clearances, cheapest paths and reachable voxels by the obvious way: scipy, and every edge of the graph."""

from __future__ import annotations

import itertools
import math

import numpy as np
from scipy import ndimage, sparse
from scipy.sparse import csgraph

STEPS = [step for step in itertools.product((-1, 0, 1), repeat=3) if any(step)]


def squared_clearances(blocked, reach):
    """Squares (d, h, w) of the distances to blocked voxels; all outside is blocked."""
    distances = ndimage.distance_transform_edt(~np.pad(blocked, reach, constant_values=True))
    inner = distances[(slice(reach, -reach),) * 3]
    return np.minimum(np.rint(inner**2), reach**2).astype(int)


def edges(squares, need):
    """Every step of a path: voxel, next voxel (both flat), and the step's length."""
    rows, columns, lengths = [], [], []
    numbers = np.arange(squares.size).reshape(squares.shape)
    for step in STEPS:
        here = tuple(slice(max(0, -k), size - max(0, k)) for k, size in zip(step, squares.shape))
        there = tuple(slice(max(0, k), size + min(0, k)) for k, size in zip(step, squares.shape))
        a, b = squares[here], squares[there]
        is_free = (b >= need) | ((a < need) & (a > 0) & (b >= a))
        rows.append(numbers[here][is_free])
        columns.append(numbers[there][is_free])
        lengths.append(np.full(is_free.sum(), math.sqrt(sum(k * k for k in step))))
    return np.concatenate(rows), np.concatenate(columns), np.concatenate(lengths)


def cheapest(squares, need, factors, start, goal):
    """Cost of the cheapest path between two voxels (z, y, x); infinite if there is none."""
    rows, columns, lengths = edges(squares, need)
    factor = factors[squares.ravel()]
    costs = 0.5 * lengths * (factor[rows] + factor[columns])
    graph = sparse.csr_matrix((costs, (rows, columns)), (squares.size,) * 2)
    begin, end = (np.ravel_multi_index(place, squares.shape) for place in (start, goal))
    return csgraph.dijkstra(graph, indices=begin)[end]


def widest(squares, is_reached, goal):
    """Square of the clearance at the narrowest voxel of the widest way to a goal; 0: no way is free.

    By trying: the greatest least clearance that still joins what is reached with the goal.
    """
    for least in sorted(set(squares[squares > 0].tolist()), reverse=True):
        labels, _ = ndimage.label((squares >= least) | is_reached, np.ones((3, 3, 3)))
        if labels[goal] and (labels[is_reached] == labels[goal]).any():
            return least
    return 0
