"""Which pairs of places see each other through voxels where the UAV may be."""

from __future__ import annotations

import numpy as np

from exploration.planning.kernels.pulling import leg_cost
from kernel_cache.compiler import njit


@njit(cache=True, nogil=True)
def straight_ways(squares: np.ndarray, need: int, places: np.ndarray) -> np.ndarray:
    """Return (n, n) the lengths, voxels, of the straight ways between places (n, 3), z, y, x; inf: closed."""
    count, plain = len(places), np.ones(1 << 16)
    lengths = np.zeros((count, count))
    for a in range(count):
        for b in range(a + 1, count):
            lengths[a, b] = lengths[b, a] = leg_cost(squares, need, plain, places[a], places[b])
    return lengths
