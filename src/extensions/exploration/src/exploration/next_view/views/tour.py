"""Few views that together show all cells, and the shortest tour through them."""

from __future__ import annotations

import numpy as np

from exploration.next_view.roadmap import Roadmap

STOPS_MAX = 8
"""A tour leads through the nearest views only: what is farther hardly changes where it begins."""


def covering(sights: np.ndarray, ways_m: np.ndarray) -> np.ndarray:
    """Return which views (k,) show together all cells that any shows, by few (greedy set cover).

    sights: (n, m) whether a view shows a cell. ways_m: (n,) of equally good views the nearer one is taken.
    """
    nearest_first, chosen = np.argsort(ways_m, kind="stable"), []
    by_cell = np.ascontiguousarray(sights[nearest_first].T)
    gains = by_cell.sum(axis=0)
    while len(gains) and gains.max() > 0:
        best = int(np.argmax(gains))
        chosen.append(nearest_first[best])
        shown = by_cell[:, best].copy()  # each cell is taken from all gains once, in a hall of thousands
        gains -= by_cell[shown].sum(axis=0)
        by_cell[shown] = False
    return np.array(chosen, np.int64)


def first_of_tour(roadmap: Roadmap, nodes: np.ndarray, home_m: np.ndarray) -> int:
    """Return which of the nodes (k,) of a roadmap the shortest tour through them visits first.

    The tour begins at the UAV, and ends at home (x, y, z) unless there are more nodes than it leads through.
    """
    nodes = nodes[np.argsort(roadmap.ways_m[nodes], kind="stable")]
    stops = nodes[:STOPS_MAX]
    if len(stops) == 1:
        return int(stops[0])
    between = np.array([roadmap.ways_from(stop) for stop in stops])
    ends = np.zeros(len(stops))
    if len(stops) == len(nodes):
        ends = between[:, roadmap.nearest(home_m)]
    return int(stops[shortest_order(roadmap.ways_m[stops], between[:, stops], ends)[0]])


def shortest_order(begins: np.ndarray, between: np.ndarray, ends: np.ndarray) -> list[int]:
    """Return the order (k,) of stops with the shortest way (Held and Karp, 1962).

    begins: (k,) the way to each stop. between: (k, k) from each to each. ends: (k,) from each to the end.
    """
    count = len(begins)
    best = np.full((1 << count, count), np.inf)
    before = np.zeros((1 << count, count), np.int64)
    best[1 << np.arange(count), np.arange(count)] = begins
    for visited in range(1, 1 << count):
        for stop in range(count):
            if not visited >> stop & 1:
                reached = best[visited] + between[:, stop]
                last = int(np.argmin(reached))
                now = visited | 1 << stop
                if reached[last] < best[now, stop]:
                    best[now, stop], before[now, stop] = reached[last], last
    visited = (1 << count) - 1
    order = [int(np.argmin(best[visited] + ends))]
    while len(order) < count:
        stop = order[-1]
        order.append(int(before[visited, stop]))
        visited ^= 1 << stop
    return order[::-1]
