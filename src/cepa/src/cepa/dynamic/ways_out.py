"""The shortest way out of the window around the UAV, through what is remembered."""

from __future__ import annotations

import math

import numpy as np

from cepa.kernels.field import stamp, ways_out
from cepa.parameters import CepaParameters

CELL_M = 0.2
CLOSED_M = 0.05
"""The way keeps so much more than r_LB, for the size of the cells."""
ROUNDS = 8
NO_WAY_M = 10.0
"""Where no way begins, progress counts as if the way were so much longer than from here."""
OWN_CELLS = 2


class WaysOut:
    """Searches again at every call; it keeps nothing but its arrays."""

    def __init__(self, parameters: CepaParameters):
        self._p = parameters
        side = 2 * round(0.5 * parameters.window_m / CELL_M) + 1
        self._distance = np.empty((side, side))
        self._way = np.empty((side, side))

    def search(self, obstacles: np.ndarray, direction: np.ndarray) -> np.ndarray | None:
        """Return the length of the shortest way out from each cell (n, n), m; None: there is none from here.

        obstacles: (n, 2) m, relative to the UAV. direction: unit vector of the reference.
        A metre within r_UB counts up to twice, for the UAV is slower there.
        """
        p = self._p
        stamp(obstacles, self._distance, CELL_M, p.r_ub)
        nearness = (p.r_ub - self._distance) / (p.r_ub - p.r_lb)
        slowness = np.where(self._distance < p.r_lb + CLOSED_M, math.inf, 1.0 + nearness)
        here = self._distance.shape[0] // 2
        own = slice(here - OWN_CELLS, here + OWN_CELLS + 1)
        slowness[own, own] = np.minimum(slowness[own, own], 3.0)  # the UAV is there, so it can leave
        ways_out(slowness, CELL_M, direction, self._way, ROUNDS)
        length = self._way[here, here]
        if math.isinf(length):
            return None
        return np.where(np.isinf(self._way), length + NO_WAY_M, self._way)
