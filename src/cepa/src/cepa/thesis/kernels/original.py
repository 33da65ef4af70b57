"""Kernel of the original steering algorithm (thesis algorithm 1), compiled as it stands."""

from __future__ import annotations

import numpy as np

from kernel_cache.compiler import njit


@njit(cache=True)
def weight(ranges: np.ndarray, cushion_lb: np.ndarray, cushion_ub: np.ndarray, offset: int) -> float:
    """Return Omega (6.3, 6.4; m2, unweighted) for cushions with their edge at ``cushion[j + offset]``."""
    total = 0.0
    for j in range(ranges.size):
        if ranges[j] <= cushion_lb[j + offset]:
            return np.inf
        if ranges[j] < cushion_ub[j + offset]:
            total += (cushion_ub[j + offset] - ranges[j]) ** 2
    return total


@njit(cache=True)
def best_of_all(
    ranges: np.ndarray,
    eligible: np.ndarray,
    alignment: np.ndarray,
    speeds: np.ndarray,
    cushions_lb: np.ndarray,
    cushions_ub: np.ndarray,
    k1: float,
    k2: float,
    k3: float,
) -> tuple[int, int, float, int]:
    """Try every eligible beam at every speed; return (beam, or -1, speed index, cost, directions tested).

    ``alignment`` (N,): cosine between each beam and v_ref; ``speeds`` (S,) m/s; ``cushions`` (S, 2N-1) m: the
    edge at [s, j - i + N - 1] for beam j and direction i. ``k1`` is k1 |v_ref| and ``k2`` is k2 / |v_ref|, as
    in equation 6.5.
    """
    count = ranges.size
    best_beam = -1
    best_speed = -1
    best_cost = np.inf
    tested = 0
    for i in range(count):
        if not eligible[i]:
            continue
        for s in range(speeds.size):
            tested += 1
            omega = weight(ranges, cushions_lb[s], cushions_ub[s], count - 1 - i)
            if omega == np.inf:
                continue
            cost = k3 * omega - speeds[s] * (k1 * alignment[i] + k2)
            if cost < best_cost:
                best_cost = cost
                best_beam = i
                best_speed = s
    return best_beam, best_speed, best_cost, tested
