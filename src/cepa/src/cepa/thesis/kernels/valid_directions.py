"""The directions in which no obstacle is in the inner cushion, at each speed (algorithm 2, line 11)."""

from __future__ import annotations

import numpy as np

from kernel_cache.compiler import njit


@njit(cache=True)
def valid_directions(
    ranges: np.ndarray, eligible: np.ndarray, reach: np.ndarray, is_even: bool, r_lb: float, d_lb: np.ndarray
) -> np.ndarray:
    """Return (S, N) bool: the beams' directions in which no obstacle is in the inner cushion.

    ``is_even`` is Grid.is_even. ``d_lb`` (S,), descending, is the inner cushion's length at each speed. An
    obstacle at range LS <= d_lb forbids the directions within asin(r_lb / LS) of it (doc/how_it_works.md).
    Overlapping intervals are united by counting.
    """
    count = ranges.size
    speeds = d_lb.size
    opened = np.zeros((speeds, count + 1), np.int32)
    width = 0
    for j in range(count):
        reading = ranges[j]
        if reading > d_lb[0]:
            continue
        while width > 0 and reading > r_lb * reach[count - 1 + width]:
            width -= 1
        while 2 * (width + 1) <= count and reading <= r_lb * reach[count + width]:
            width += 1
        slowest = speeds - 1  # what forbids a speed forbids all higher ones
        while reading > d_lb[slowest]:
            slowest -= 1
        first, last = j - width, j + width
        if not is_even:
            first, last = _across_the_seam(j, first, last, reading, reach, r_lb)
        _count_interval(opened[slowest], first, last, count)
    return _unite(opened, eligible)


@njit(cache=True)
def _across_the_seam(
    j: int, first: int, last: int, reading: float, reach: np.ndarray, r_lb: float
) -> tuple[int, int]:
    """Return (first, last) of the beams that an obstacle at beam ``j`` forbids, where the turn closes.

    The last and the first beam are nearer to each other or farther apart than other neighbours. So what lies
    beyond this seam is looked up by its own angle. A beam beyond the seam has its index plus or minus N.
    """
    count = (reach.size + 1) // 2
    if last >= count - 1:
        last = count - 1
        while last - first + 1 < count and reading <= r_lb * reach[j - (last + 1 - count) + count - 1]:
            last += 1
    if first <= 0:
        first = 0
        while last - first + 1 < count and reading <= r_lb * reach[j - (first - 1 + count) + count - 1]:
            first -= 1
    return first, last


@njit(cache=True)
def _count_interval(opened: np.ndarray, first: int, last: int, count: int) -> None:
    if first < 0:
        opened[0] += 1
        opened[last + 1] -= 1
        opened[first + count] += 1
    elif last >= count:
        opened[first] += 1
        opened[0] += 1
        opened[last - count + 1] -= 1
    else:
        opened[first] += 1
        opened[last + 1] -= 1


@njit(cache=True)
def _unite(opened: np.ndarray, eligible: np.ndarray) -> np.ndarray:
    speeds = opened.shape[0]
    count = eligible.size
    valid = np.empty((speeds, count), np.bool_)
    for s in range(speeds - 1, -1, -1):
        covering = 0
        for i in range(count):
            covering += opened[s, i]
            free = eligible[i] and covering == 0
            valid[s, i] = free and (s == speeds - 1 or valid[s + 1, i])
    return valid
