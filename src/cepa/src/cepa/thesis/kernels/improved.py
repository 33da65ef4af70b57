"""Kernels of the improved steering: cost of a direction, and the search for the best one.

``reach`` is Grid.reach: the cushion of equation 6.7 is min(d, r * reach).
"""

from __future__ import annotations

import numpy as np

from kernel_cache.compiler import njit

BEST_FIRST = 128
"""Directions tested before the second bound is worth its while; most searches end sooner."""

STEPS = 8
"""Steps of the staircase under the cushion's edge."""

GAP_BEAMS = 8
"""Runs of near beams that are less apart than this are one run."""

ROUNDING = 1e-7
"""Slack of the staircase's bound: its running sums round differently from the cost's."""


@njit(cache=True)
def intrusion(
    ranges: np.ndarray,
    cos: np.ndarray,
    sin: np.ndarray,
    towards_x: float,
    towards_y: float,
    r_lb: float,
    d_lb: float,
    r_ub: float,
    d_ub: float,
) -> float:
    """Return Omega (6.3, 6.4, 6.7; m2, unweighted) of any direction; inf when an obstacle forbids it."""
    total = 0.0
    for j in range(ranges.size):
        reading = ranges[j]
        if reading >= d_ub:
            continue
        edge_lb = r_lb
        edge_ub = r_ub
        if cos[j] * towards_x + sin[j] * towards_y > 0.0:
            across = abs(sin[j] * towards_x - cos[j] * towards_y)
            edge_lb = r_lb / across if across * d_lb > r_lb else d_lb
            edge_ub = r_ub / across if across * d_ub > r_ub else d_ub
        if reading <= edge_lb:
            return np.inf
        if reading < edge_ub:
            total += (edge_ub - reading) ** 2
    return total


@njit(cache=True)
def best_velocity(
    ranges: np.ndarray,
    cos: np.ndarray,
    sin: np.ndarray,
    reach: np.ndarray,
    valid: np.ndarray,
    towards_x: float,
    towards_y: float,
    first: int,
    speeds: np.ndarray,
    r_ub: float,
    d_ub: np.ndarray,
    k1: float,
    k2: float,
    k3: float,
    best_cost: float,
) -> tuple[int, int, float, int]:
    """Search the valid directions best-first; return (beam, or -1, speed index, cost, directions tested).

    ``speeds`` (S,) m/s, descending; ``towards`` is v_ref's unit vector, ``first`` the beam nearest to it,
    ``d_ub`` (S,) the outer cushion's length. ``k1`` is k1 |v_ref|, ``k2`` is k2 / |v_ref|, so that a velocity
    v at angle psi to v_ref costs k3 Omega - |v| (k1 cos psi + k2) (equation 6.5). Only what costs less than
    ``best_cost`` is returned. ``valid`` is changed: what has been tested is struck out.

    Exact: what is not computed has a lower bound of its cost that is no better than the best cost. The bound
    here takes for Omega the sum over LS < r_ub of (r_ub - LS)^2, which every direction has; nothing that
    remains can be better once the least bound is not. A search that takes longer goes on in ``_search_on``.
    """
    count = ranges.size
    run_first, run_end = _runs(ranges, d_ub[0])
    floor = k3 * np.sum(np.maximum(r_ub - ranges, 0.0) ** 2)
    alignment = cos * towards_x + sin * towards_y
    order = np.empty(count, np.int64)  # the beams by angle from v_ref, as far as the search has come
    order[0] = first
    ordered, left, right = 1, first + 1, first - 1
    position = np.zeros(speeds.size, np.int64)
    bound = floor - speeds * (k1 * alignment[first] + k2)

    best_beam, best_speed, tested = -1, -1, 0
    while tested < BEST_FIRST:
        s = int(np.argmin(bound))
        if bound[s] >= best_cost:
            return best_beam, best_speed, best_cost, tested
        i = order[position[s]]
        if valid[s, i]:
            valid[s, i] = False
            tested += 1
            omega = _omega(ranges, run_first, run_end, reach, i - count + 1, r_ub, d_ub[s])
            cost = bound[s] - floor + k3 * omega
            if cost < best_cost:
                best_cost, best_beam, best_speed = cost, i, s
        position[s] += 1
        if position[s] == count:
            bound[s] = np.inf
            continue
        if position[s] == ordered:
            if alignment[left % count] >= alignment[right % count]:
                order[ordered] = left % count
                left += 1
            else:
                order[ordered] = right % count
                right -= 1
            ordered += 1
        bound[s] = floor - speeds[s] * (k1 * alignment[order[position[s]]] + k2)
    travels = -np.outer(speeds, k1 * alignment + k2)
    best = best_beam, best_speed, best_cost, tested
    return _search_on(ranges, run_first, run_end, reach, valid, travels, floor, r_ub, d_ub, k3, best)


@njit(cache=True)
def _search_on(
    ranges: np.ndarray,
    run_first: np.ndarray,
    run_end: np.ndarray,
    reach: np.ndarray,
    valid: np.ndarray,
    travels: np.ndarray,
    floor: float,
    r_ub: float,
    d_ub: np.ndarray,
    k3: float,
    best: tuple[int, int, float, int],
) -> tuple[int, int, float, int]:
    """Search what is left of ``valid`` by a second bound, nearer to the truth.

    Arguments as in ``best_velocity``; ``travels`` (S, N): the cost without Omega. The bound is computed of
    all that the first one leaves; tested is the candidate of the least one, then what is below the best cost.
    """
    best_beam, best_speed, best_cost, tested = best
    speeds, count = valid.shape
    bounds = np.full(speeds * count, np.inf)
    for s in range(speeds):
        promising = np.flatnonzero(valid[s] & (travels[s] + floor < best_cost))
        if promising.size > 0:
            windows, sums = _staircase(ranges, reach, r_ub, d_ub[s])
            for i in promising:
                bounds[s * count + i] = travels[s, i] + k3 * _omega_of_staircase(i, windows, sums) - ROUNDING
    start = int(np.argmin(bounds))
    for k in range(bounds.size):
        candidate = (start + k) % bounds.size
        if bounds[candidate] < best_cost:
            s, i = candidate // count, candidate % count
            tested += 1
            omega = _omega(ranges, run_first, run_end, reach, i - count + 1, r_ub, d_ub[s])
            cost = travels[s, i] + k3 * omega
            if cost < best_cost:
                best_cost, best_beam, best_speed = cost, i, s
    return best_beam, best_speed, best_cost, tested


@njit(cache=True)
def _runs(ranges: np.ndarray, distance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return (first, end) of the runs of beams in which something is nearer than ``distance``."""
    first = np.empty(ranges.size, np.int64)
    end = np.empty(ranges.size, np.int64)
    found = 0
    for j in range(ranges.size):
        if ranges[j] < distance:
            if found > 0 and j - end[found - 1] < GAP_BEAMS:
                end[found - 1] = j + 1
            else:
                first[found] = j
                end[found] = j + 1
                found += 1
    return first[:found], end[:found]


@njit(cache=True, fastmath={"reassoc", "contract", "nsz"})
def _omega(
    ranges: np.ndarray,
    first: np.ndarray,
    end: np.ndarray,
    reach: np.ndarray,
    offset: int,
    r_ub: float,
    d_ub: float,
) -> float:
    """Return Omega (m2, unweighted) of a direction that nothing forbids, over the runs of ``_runs``.

    The terms may be added in any order, so that the compiler can compute several at once.
    """
    total = 0.0
    for run in range(first.size):
        for j in range(first[run], end[run]):
            depth = max(min(d_ub, r_ub * reach[j - offset]) - ranges[j], 0.0)
            total += depth * depth
    return total


@njit(cache=True)
def _staircase(
    ranges: np.ndarray, reach: np.ndarray, r_ub: float, d_ub: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return (windows (STEPS,), sums (N + 1, STEPS + 1)) of the staircase under the cushion's edge.

    The edge is at least d_ub - k (d_ub - r_ub) / STEPS within ``windows[k]`` beams of the direction, and r_ub
    everywhere. ``sums[:, k]`` are running sums over the beams of what the intrusion (m2) into a circle of
    step k's height exceeds that into the next step's; the last column is the circle of r_ub.
    """
    count = ranges.size
    heights = d_ub - np.arange(STEPS + 1) * ((d_ub - r_ub) / STEPS)
    sums = np.empty((count + 1, STEPS + 1))
    sums[0] = 0.0
    for j in range(count):
        depth = max(heights[0] - ranges[j], 0.0)
        for k in range(STEPS):
            next_depth = max(heights[k + 1] - ranges[j], 0.0)
            sums[j + 1, k] = sums[j, k] + (depth * depth - next_depth * next_depth)
            depth = next_depth
        sums[j + 1, STEPS] = sums[j, STEPS] + depth * depth
    windows = np.empty(STEPS, np.int64)
    width = 0
    for k in range(STEPS):
        while 2 * (width + 1) < count and min(d_ub, r_ub * reach[count + width]) >= heights[k]:
            width += 1
        windows[k] = max(width - 1, 0)  # where the turn closes, the beams need not be equally far apart
    return windows, sums


@njit(cache=True)
def _omega_of_staircase(i: int, windows: np.ndarray, sums: np.ndarray) -> float:
    """Return a lower bound of Omega (m2) in beam ``i``'s direction: the intrusions into the staircase."""
    count = sums.shape[0] - 1
    total = sums[count, STEPS]
    for k in range(STEPS):
        first, end = i - windows[k], i + windows[k] + 1
        total += sums[end if end <= count else end - count, k] - sums[max(first, 0), k]
        if first < 0:
            total += sums[count, k] - sums[first + count, k]
        if end > count:
            total += sums[count, k]
    return total
