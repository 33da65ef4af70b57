"""Kernels of the improved steering: cost of a direction, removal of unviable ones, best-first search.

``reach`` is Grid.reach: the cushion of equation 6.7 is min(d, r * reach).
"""

import numpy as np
from numba import njit


@njit(cache=True)
def intrusion(ranges, cos, sin, towards_x, towards_y, r_lb, d_lb, r_ub, d_ub):
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
def valid_directions(ranges, eligible, reach, r_lb, d_lb):
    """Return (S, N) bool: the beams' directions in which no obstacle is in the inner cushion.

    ``d_lb`` (S,), descending, is the inner cushion's length at each speed. An obstacle at range LS <= d_lb
    forbids the directions within asin(r_lb / LS) of it (README.md); overlapping intervals are united
    by counting.
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
        while 2 * (width + 1) < count and reading <= r_lb * reach[count + width]:
            width += 1
        slowest = speeds - 1  # what forbids a speed forbids all higher ones
        while reading > d_lb[slowest]:
            slowest -= 1
        _count_interval(opened[slowest], j - width, j + width, count)
    return _unite(opened, eligible)


@njit(cache=True)
def _count_interval(opened, first, last, count):
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
def _unite(opened, eligible):
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


@njit(cache=True)
def best_velocity(
    ranges, cos, sin, reach, valid, towards_x, towards_y, first, speeds, r_ub, d_ub, k1, k2, k3, best_cost
):
    """Search the valid directions best-first; return (beam, or -1, speed index, cost, directions tested).

    ``speeds`` (S,) m/s, descending; ``speeds[0]`` times 1 / its fraction is |v_ref|, whose unit vector is
    ``towards``. ``k1`` is k1 |v_ref|, ``k2`` is k2 / |v_ref|, so that a velocity v at angle psi to v_ref
    costs k3 Omega - |v| (k1 cos psi + k2) (equation 6.5). ``first`` is the beam nearest to v_ref. Only what
    costs less than ``best_cost`` is returned.

    Exact: Omega is at least the sum over LS < r_ub of (r_ub - LS)^2 in every direction, and the two other
    terms are known, so that nothing that remains when the least bound reaches the best cost can be better.
    """
    count = ranges.size
    near = np.empty(count, np.int64)
    near_ranges = np.empty(count)
    nears = 0
    floor = 0.0
    for j in range(count):
        if ranges[j] < d_ub[0]:
            near[nears] = j + count - 1
            near_ranges[nears] = ranges[j]
            nears += 1
            if ranges[j] < r_ub:
                floor += (r_ub - ranges[j]) ** 2
    floor *= k3

    order = np.empty(count, np.int64)  # the beams by angle from v_ref, extended as far as the search needs it
    order[0] = first
    ordered = 1
    left = first + 1
    right = first - 1

    position = np.zeros(speeds.size, np.int64)
    bound = np.empty(speeds.size)
    alignment = cos[first] * towards_x + sin[first] * towards_y
    for s in range(speeds.size):
        bound[s] = floor - speeds[s] * (k1 * alignment + k2)

    best_beam = -1
    best_speed = -1
    tested = 0
    while True:
        s = np.argmin(bound)
        if bound[s] >= best_cost:
            return best_beam, best_speed, best_cost, tested
        i = order[position[s]]
        if valid[s, i]:
            omega = 0.0
            for k in range(nears):
                edge = min(d_ub[s], r_ub * reach[near[k] - i])
                if near_ranges[k] < edge:
                    omega += (edge - near_ranges[k]) ** 2
            cost = bound[s] - floor + k3 * omega
            tested += 1
            if cost < best_cost:
                best_cost = cost
                best_beam = i
                best_speed = s
        position[s] += 1
        if position[s] == count:
            bound[s] = np.inf
            continue
        if position[s] == ordered:
            a = left % count
            b = right % count
            if cos[a] * towards_x + sin[a] * towards_y >= cos[b] * towards_x + sin[b] * towards_y:
                order[ordered] = a
                left += 1
            else:
                order[ordered] = b
                right -= 1
            ordered += 1
        i = order[position[s]]
        bound[s] = floor - speeds[s] * (k1 * (cos[i] * towards_x + sin[i] * towards_y) + k2)
