"""How far a place is beyond the free space: what has been seen free."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.kernels.angles import angle_of
from cepa.dynamic.kernels.clearance import layer_at
from cepa.dynamic.kernels.response import State
from kernel_cache.compiler import njit

BY_REACH = 2
"""Of ``unseen``: ``reach`` tells how far the UAV may go there."""


@njit(cache=True, inline="always")
def beyond_reach(reach: np.ndarray, x: float, y: float) -> float:
    """Return how far (x, y) is beyond ``reach``, m."""
    bins = np.int32(reach.size)
    b = np.int32(math.floor(angle_of(x, y) * bins / (2.0 * math.pi) + 0.5))
    return math.sqrt(x * x + y * y) - reach[np.uint32(b + bins if b < 0 else b)]


@njit(cache=True, inline="always")
def beyond_free_space(
    reach: np.ndarray, unseen: np.ndarray, unseen_cell_m: float, layer_m: float, state: State
) -> float:
    """Return how far the UAV is beyond what has been seen, m; with layers 1 or 0 but for BY_REACH."""
    x, y = state[0][0], state[1][0]
    if unseen.shape[0]:
        layer = layer_at(unseen.shape[0], layer_m, state[2][0])
        half = unseen.shape[1] // 2
        i = math.floor(y / unseen_cell_m + 0.5) + half
        j = math.floor(x / unseen_cell_m + 0.5) + half
        outside = layer < 0 or min(i, j) < 0 or max(i, j) > 2 * half
        if outside or unseen[layer, i, j] != BY_REACH:
            return 1.0 if outside or unseen[layer, i, j] else 0.0
    return beyond_reach(reach, x, y)


@njit(cache=True)
def leaves_reach(path: np.ndarray, flown: int, reach: np.ndarray, most: np.ndarray) -> bool:
    """Whether one of the ``flown`` first places of ``path`` (2, n), m, is beyond ``reach``.

    ``most`` (n,): it may be so far beyond, m.
    """
    leaves = False
    for k in range(flown):  # without a branch, so that several places go at once
        leaves |= beyond_reach(reach, path[0, k], path[1, k]) > max(0.0, most[k])
    return leaves
