"""Which groups of points hang together, in memory that grows with the points and not with their pairs."""

from __future__ import annotations

from itertools import product
from typing import Iterator, Sequence

import numpy as np
from scipy.spatial import cKDTree

HALF = [each for each in product((-1, 0, 1), repeat=3) if each >= (0, 0, 0)]
"""Steps from a cube to itself and to half of the cubes around it; the others are met from the other side."""


def linked(groups: Sequence[np.ndarray], apart_m: float) -> list[list[int]]:
    """Return the groups, (n, 3) points each, that hang together: two of them have points within apart_m."""
    owners = list(range(len(groups)))

    def owner(k: int) -> int:
        while owners[k] != k:
            owners[k] = owners[owners[k]]
            k = owners[k]
        return k

    trees: dict[int, cKDTree] = {}
    for a, b in _beside(groups, apart_m):
        first, second = owner(a), owner(b)
        if first == second:
            continue
        small, large = (a, b) if len(groups[a]) < len(groups[b]) else (b, a)
        if large not in trees:
            trees[large] = cKDTree(groups[large])
        if (
            trees[large].query(groups[small], distance_upper_bound=np.nextafter(apart_m, np.inf))[0].min()
            <= apart_m
        ):
            owners[max(first, second)] = min(first, second)
    together: dict[int, list[int]] = {}
    for k in range(len(groups)):
        together.setdefault(owner(k), []).append(k)
    return list(together.values())


def pieces_of(points_m: np.ndarray, apart_m: float) -> list[np.ndarray]:
    """Return the indices of points (n, 3) that hang together: each with another one within apart_m."""
    side_m = apart_m / np.sqrt(3.0)  # all points in a cube hang together
    _, of = np.unique(np.floor(points_m / side_m).astype(np.int64), axis=0, return_inverse=True)
    order = np.argsort(of, kind="stable")
    cubes = np.split(order, np.searchsorted(of[order], np.arange(1, int(of.max()) + 1)))
    return [np.concatenate([cubes[k] for k in own]) for own in linked([points_m[k] for k in cubes], apart_m)]


def _beside(groups: Sequence[np.ndarray], apart_m: float) -> Iterator[tuple[int, int]]:
    """Yield pairs of groups that have points in one cube of apart_m, or in two that touch."""
    if not groups:
        return
    of = np.repeat(np.arange(len(groups)), [len(each) for each in groups])
    cubes = np.floor(np.concatenate(groups) / apart_m).astype(np.int64)
    cubes -= cubes.min(axis=0) - 1
    spans = cubes.max(axis=0) + 2
    keys = (cubes[:, 0] * spans[1] + cubes[:, 1]) * spans[2] + cubes[:, 2]
    rows = np.unique(np.column_stack((keys, of)), axis=0)
    for step in HALF:
        shift = (step[0] * spans[1] + step[1]) * spans[2] + step[2]
        low, high = (np.searchsorted(rows[:, 0], rows[:, 0] + shift, side=side) for side in ("left", "right"))
        counts = high - low
        left = np.repeat(np.arange(len(rows)), counts)
        right = (
            np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts) + np.repeat(low, counts)
        )
        pairs = np.column_stack((rows[left, 1], rows[right, 1]))
        pairs = np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0)
        yield from map(tuple, pairs.tolist())
