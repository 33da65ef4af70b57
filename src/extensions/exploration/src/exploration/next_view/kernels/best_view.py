"""The place with the greatest information gain for its time: that shows most of the border of the known."""

from __future__ import annotations

import math

import numpy as np

from exploration.next_view.kernels.views import has_beam, is_open
from exploration.planning.kernels.heap import drop_first, push
from kernel_cache.compiler import njit

CUBES = 4
"""Cubes of cells along the lidar's reach: then few cells are looked at that are too far."""
FIRST, MOST = 16, 1000
"""So many places are looked at first, to know what the best one shows at least; and so many at most then."""
MANY, MOST_OF_MANY = 20_000, 100
"""Of more places than the first, as in halls, only so many: most of them have been looked at before."""


@njit(cache=True, nogil=True)
def best_view(
    kinds: np.ndarray,
    places: np.ndarray,
    times_s: np.ndarray,
    cells: np.ndarray,
    counts: np.ndarray,
    slopes: tuple[float, float],
    reaches: tuple[float, float],
    least: tuple[float, float],
    gains: np.ndarray,
) -> tuple[int, int]:
    """Return the place that shows most frontier voxels a second, and how many it shows; -1, 0 if none does.

    All that is in the cubes around a place is more than what is in reach of its beams, and that is more than
    what it shows. So only the places that could still be the best are looked at in full, and the reach of
    beams is looked at for those only whose cubes hold more than the next best has in reach. The cost grows
    with the border near the UAV, not with the whole border.

    Args:
        kinds: as in `seen_from`.
        places: likewise.
        times_s: (n,) that each view costs.
        cells: as in `seen_from`.
        counts: likewise.
        slopes: likewise.
        reaches: likewise.
        least: voxels, and voxels a second, that a view must show.
        gains: (n,) the voxels that each place shows; -1: not known. Those that are counted are filled in.
    """
    side = max(1, math.ceil(reaches[1] / CUBES))
    low, size = np.zeros(3, np.int64), np.zeros(3, np.int64)
    for axis in range(3):
        low[axis] = cells[:, axis].min()
        size[axis] = (cells[:, axis].max() - low[axis]) // side + 1
    order, firsts, sums = _cubes(cells, counts, low, size, side)
    table = _table(sums, size)
    bounds = np.zeros(len(places))
    for n in range(len(places)):
        total = _total(table, _window(places[n], slopes, reaches[1], low, size, side))
        bounds[n] = total / times_s[n] if total >= least[0] else 0.0
    within = np.empty(len(cells), np.int64)
    shown = (kinds, places, times_s, cells, counts, slopes, reaches)
    windows = (order, firsts, low, size, side)
    best, best_gain, best_rate = -1, 0, least[1]
    by_bound = np.argsort(-bounds)
    for n in by_bound[:FIRST]:  # what they show is a bound for all others
        known, bound = _within(n, shown, windows, within)
        gains[n] = gain = gains[n] if gains[n] >= 0 else _open(n, shown, within[:known])
        if bound >= least[0] and gain >= least[0] and gain / times_s[n] > best_rate:
            best, best_gain, best_rate = n, gain, gain / times_s[n]
    candidates = by_bound[: np.sum(bounds > best_rate)]
    keys, items = np.empty(len(candidates)), np.empty(len(candidates), np.int64)
    waiting, begun = 0, 0
    left = MOST if len(places) <= MANY else MOST_OF_MANY
    for _ in range(MOST):  # by what is in reach of their beams, most first
        while begun < len(candidates) and (waiting == 0 or bounds[candidates[begun]] >= -keys[0]):
            n = candidates[begun]
            push(keys, items, waiting, -_within(n, shown, windows, within)[1] / times_s[n], n)
            waiting, begun = waiting + 1, begun + 1
        if waiting == 0 or -keys[0] <= best_rate:
            break
        n = items[0]
        waiting -= 1
        drop_first(keys, items, waiting)
        if gains[n] < 0:
            if left == 0:
                continue
            left -= 1
            known, _ = _within(n, shown, windows, within)
            gains[n] = _open(n, shown, within[:known])
        gain = gains[n]
        if gain >= least[0] and gain / times_s[n] > best_rate:
            best, best_gain, best_rate = n, gain, gain / times_s[n]
    return best, best_gain


@njit(cache=True, nogil=True)
def _within(n: int, shown: tuple, windows: tuple, within: np.ndarray) -> tuple[int, int]:
    """Set `within` to the cells that the beams from a place reach; return how many, and their voxels."""
    _, places, _, cells, counts, slopes, reaches = shown
    order, firsts, low, size, side = windows
    z, y, x = _window(places[n], slopes, reaches[1], low, size, side)
    known, voxels = 0, 0
    for c in range(z[0], z[1]):
        for b in range(y[0], y[1]):
            first = (c * size[1] + b) * size[2]
            for k in range(firsts[first + x[0]], firsts[first + x[1]]):  # cubes in a row lie together
                m = order[k]
                if has_beam(places[n], cells[m], slopes, reaches):
                    within[known] = m
                    known += 1
                    voxels += counts[m]
    return known, voxels


@njit(cache=True, nogil=True)
def _open(n: int, shown: tuple, within: np.ndarray) -> int:
    """Return the voxels of those cells that nothing hides from a place."""
    kinds, places, _, cells, counts, _, _ = shown
    voxels = 0
    for m in within:
        if is_open(kinds, places[n], cells[m]):
            voxels += counts[m]
    return voxels


@njit(cache=True, nogil=True)
def _cubes(
    cells: np.ndarray, counts: np.ndarray, low: np.ndarray, size: np.ndarray, side: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the cells (m,) sorted by cubes, where those of each cube begin, and its frontier voxels."""
    cubes = np.empty(len(cells), np.int64)
    firsts, sums = (
        np.zeros(size[0] * size[1] * size[2] + 1, np.int64),
        np.zeros(size[0] * size[1] * size[2], np.int64),
    )
    for m in range(len(cells)):
        z, y, x = (
            (cells[m, 0] - low[0]) // side,
            (cells[m, 1] - low[1]) // side,
            (cells[m, 2] - low[2]) // side,
        )
        cubes[m] = (z * size[1] + y) * size[2] + x
        firsts[cubes[m] + 1] += 1
        sums[cubes[m]] += counts[m]
    firsts = np.cumsum(firsts)
    return np.argsort(cubes, kind="mergesort"), firsts, sums


@njit(cache=True, nogil=True)
def _table(sums: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return what all cubes hold before each corner of cubes, (z, y, x) (Crow, 1984: summed-area tables)."""
    table = np.zeros((size[0] + 1, size[1] + 1, size[2] + 1), np.int64)
    for c in range(size[0]):
        for b in range(size[1]):
            row = 0
            for a in range(size[2]):
                row += sums[(c * size[1] + b) * size[2] + a]
                before = table[c, b + 1, a + 1] + table[c + 1, b, a + 1] - table[c, b, a + 1]
                table[c + 1, b + 1, a + 1] = row + before
    return table


@njit(cache=True, nogil=True)
def _total(table: np.ndarray, window: tuple[tuple[int, int], tuple[int, int], tuple[int, int]]) -> int:
    """Return what the cubes of a window hold."""
    (c, d), (b, e), (a, f) = window
    near = table[c, e, f] - table[c, b, f] - table[c, e, a] + table[c, b, a]
    far = table[d, e, f] - table[d, b, f] - table[d, e, a] + table[d, b, a]
    return far - near


@njit(cache=True, nogil=True)
def _window(
    place: np.ndarray,
    slopes: tuple[float, float],
    reach: float,
    low: np.ndarray,
    size: np.ndarray,
    side: int,
) -> tuple[tuple[int, int], tuple[int, int], tuple[int, int]]:
    """Return along z, y and x the first cube that beams from a place may reach, and the next after them."""
    up = min(max(slopes[1], 0.0) * reach + 1.0, reach)
    down = min(max(-slopes[0], 0.0) * reach + 1.0, reach)
    return (
        _cubes_between(place[0] - down, place[0] + up, low[0], size[0], side),
        _cubes_between(place[1] - reach, place[1] + reach, low[1], size[1], side),
        _cubes_between(place[2] - reach, place[2] + reach, low[2], size[2], side),
    )


@njit(cache=True, nogil=True)
def _cubes_between(first: float, last: float, low: int, size: int, side: int) -> tuple[int, int]:
    begin = max(math.floor((first - low) / side), 0)
    end = min(math.floor((last - low) / side) + 1, size)
    return min(begin, size), max(end, min(begin, size))
