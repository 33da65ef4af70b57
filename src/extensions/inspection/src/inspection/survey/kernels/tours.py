"""Short closed tours: nearest neighbour, 2-opt and Or-opt with perturbation, and the 1-tree bound."""

from __future__ import annotations

import numpy as np

from kernel_cache.compiler import njit

LEAST = 1e-7
"""Smaller gains do not count."""
LONGEST_CHAIN = 3
"""Places that Or-opt moves together."""


@njit(cache=True, nogil=True)
def length_of(costs: np.ndarray, tour: np.ndarray) -> float:
    """Return the cost of a closed tour (n,)."""
    total = 0.0
    for k in range(len(tour)):
        total += costs[tour[k], tour[(k + 1) % len(tour)]]
    return total


@njit(cache=True, nogil=True)
def nearest_neighbour(costs: np.ndarray, start: int) -> np.ndarray:
    """Return the tour (n,) that goes on to the nearest place that is left."""
    count = len(costs)
    tour, is_left = np.empty(count, np.int64), np.ones(count, np.bool_)
    here = start
    for k in range(count):
        tour[k], is_left[here] = here, False
        best, following = np.inf, here
        for other in range(count):
            if is_left[other] and costs[here, other] < best:
                best, following = costs[here, other], other
        here = following
    return tour


@njit(cache=True, nogil=True)
def _swap_edges(costs: np.ndarray, tour: np.ndarray) -> bool:
    """Reverse parts of a tour while that makes it shorter (2-opt). Return whether it has changed."""
    count, has_changed = len(tour), False
    for i in range(count - 1):
        for j in range(i + 1, count):
            a, b = tour[i], tour[i + 1]
            c, d = tour[j], tour[(j + 1) % count]
            if costs[a, c] + costs[b, d] < costs[a, b] + costs[c, d] - LEAST:
                tour[i + 1 : j + 1] = tour[i + 1 : j + 1][::-1].copy()
                has_changed = True
    return has_changed


@njit(cache=True, nogil=True)
def _move_chains(costs: np.ndarray, tour: np.ndarray) -> bool:
    """Move chains of up to three places to where they cost less (Or-opt). Return whether it has changed."""
    count, has_changed = len(tour), False
    for length in range(1, min(LONGEST_CHAIN, count - 2) + 1):
        for i in range(count):
            first, last = tour[i], tour[(i + length - 1) % count]
            before, after = tour[i - 1], tour[(i + length) % count]
            saved = costs[before, first] + costs[last, after] - costs[before, after]
            best, place, is_turned = saved - LEAST, -1, False
            for step in range(length, count - 1):
                j = (i + step) % count
                a, b = tour[j], tour[(j + 1) % count]
                plain = costs[a, first] + costs[last, b] - costs[a, b]
                turned = costs[a, last] + costs[first, b] - costs[a, b]
                if plain < best:
                    best, place, is_turned = plain, step, False
                if turned < best:
                    best, place, is_turned = turned, step, True
            if place < 0:
                continue
            turned_tour = np.concatenate((tour[i:], tour[:i]))
            chain = turned_tour[:length].copy()
            rest = turned_tour[length:]
            at = place - length + 1
            tour[:at], tour[at : at + length] = rest[:at], chain[::-1] if is_turned else chain
            tour[at + length :] = rest[at:]
            has_changed = True
    return has_changed


@njit(cache=True, nogil=True)
def shorten(costs: np.ndarray, tour: np.ndarray) -> None:
    """Improve a tour (n,) in place until neither 2-opt nor Or-opt finds a gain."""
    if len(tour) < 4:
        return
    while _swap_edges(costs, tour) or _move_chains(costs, tour):
        pass


@njit(cache=True, nogil=True)
def perturb(costs: np.ndarray, tour: np.ndarray, cuts: np.ndarray, near: int) -> np.ndarray:
    """Return the best tour of many: each exchanges two neighbouring parts (double bridge) and is improved.

    Args:
        costs: (n, n), symmetric.
        tour: (n,) to begin with.
        cuts: (k, 3) numbers 0..1 drawn at random: where, and how long both parts are.
        near: greatest length of a part.
    """
    count = len(tour)
    best, best_length = tour.copy(), length_of(costs, tour)
    if count < 8:
        return best
    near = min(near, (count - 2) // 2)
    for k in range(len(cuts)):
        begin = int(cuts[k, 0] * count)
        one, two = 1 + int(cuts[k, 1] * near), 1 + int(cuts[k, 2] * near)
        turned = np.concatenate((best[begin:], best[:begin]))
        new = np.concatenate(
            (turned[:1], turned[1 + one : 1 + one + two], turned[1 : 1 + one], turned[1 + one + two :])
        )
        shorten(costs, new)
        length = length_of(costs, new)
        if length < best_length - LEAST:
            best, best_length = new, length
    return best


@njit(cache=True, nogil=True)
def one_tree_bound(costs: np.ndarray, upper: float, steps: int) -> float:
    """Return a lower bound of all closed tours (Held and Karp, 1971), by subgradient steps on 1-trees.

    Args:
        costs: (n, n), symmetric.
        upper: length of a known tour.
        steps: of the subgradient.
    """
    count = len(costs)
    if count < 3:
        return 2.0 * costs[0, count - 1] if count == 2 else 0.0
    prices, best, factor = np.zeros(count), 0.0, 2.0
    degrees, parents, keys = np.zeros(count), np.zeros(count, np.int64), np.zeros(count)
    for _ in range(steps):
        degrees[:] = 0.0
        keys[:] = np.inf
        is_in = np.zeros(count, np.bool_)
        is_in[0] = True  # joined at the end, by its two cheapest edges
        here, total = 1, 0.0
        is_in[1] = True
        for _joined in range(count - 2):
            following, least = -1, np.inf
            for other in range(1, count):
                if is_in[other]:
                    continue
                cost = costs[here, other] + prices[here] + prices[other]
                if cost < keys[other]:
                    keys[other], parents[other] = cost, here
                if keys[other] < least:
                    least, following = keys[other], other
            is_in[following] = True
            total += least
            degrees[following] += 1.0
            degrees[parents[following]] += 1.0
            here = following
        first, second, a, b = np.inf, np.inf, -1, -1
        for other in range(1, count):
            cost = costs[0, other] + prices[0] + prices[other]
            if cost < first:
                second, b = first, a
                first, a = cost, other
            elif cost < second:
                second, b = cost, other
        total += first + second
        degrees[0] = 2.0
        degrees[a] += 1.0
        degrees[b] += 1.0
        bound = total - 2.0 * prices.sum()
        if bound > best:
            best = bound
        off = degrees - 2.0
        size = (off * off).sum()
        if size == 0.0:
            break
        factor *= 0.985
        prices += factor * max(upper - bound, 1e-9) / size * off
    return best
