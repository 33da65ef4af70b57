"""The shortest way out of the window around the UAV, through what is remembered."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cepa.kernels.field import favour, stamp, trace, ways_out
from cepa.parameters import CepaParameters

CELL_M = 0.2
CLOSED_M = 0.05
"""The way keeps so much more than r_LB, for the size of the cells."""
ROUNDS = 8
NO_WAY_M = 10.0
"""Where no way begins, progress counts as if the way were so much longer than from here."""
OWN_CELLS, OWN_SLOWNESS = 2, 3.0
FAVOUR = 0.8
"""A metre along the last way counts so much: of two ways of almost one length the UAV keeps to the first."""


class Ways(NamedTuple):
    """The lengths of the shortest ways out."""

    length: np.ndarray
    """(n, n) m: from each cell."""
    offset_x: float
    """m: of the UAV from the grid's middle."""
    offset_y: float


class WaysOut:
    """Searches again at every call. The grid's cells are fixed to the odometry's frame."""

    def __init__(self, parameters: CepaParameters):
        self._p = parameters
        side = 2 * round(0.5 * parameters.window_m / CELL_M) + 1
        self._distance = np.empty((side, side))
        self._length = np.empty((side, side))
        self._last = np.empty((8 * side, 2), np.int64)
        self.reset()

    def reset(self) -> None:
        """Forget the last way."""
        self._last_count = 0

    def search(self, obstacles: np.ndarray, direction: np.ndarray, x_m: float, y_m: float) -> Ways | None:
        """Return the ways out; None: there is none from here.

        obstacles: (n, 2) m, relative to the UAV, which is at (x_m, y_m) in the odometry's frame.
        direction: unit vector of the reference. A metre within r_UB counts up to twice, for the UAV is slower
        there.
        """
        p = self._p
        column, row = round(x_m / CELL_M), round(y_m / CELL_M)
        offset = x_m - column * CELL_M, y_m - row * CELL_M
        stamp(obstacles + offset, self._distance, CELL_M, p.r_ub)
        nearness = (p.r_ub - self._distance) / (p.r_ub - p.r_lb)
        slowness = np.where(self._distance < p.r_lb + CLOSED_M, math.inf, 1.0 + nearness)
        favour(self._last[: self._last_count], column, row, FAVOUR, slowness)
        here = self._distance.shape[0] // 2
        own = slice(here - OWN_CELLS, here + OWN_CELLS + 1)
        slowness[own, own] = np.minimum(slowness[own, own], OWN_SLOWNESS)  # the UAV is there: it can leave
        ways_out(slowness, CELL_M, direction, self._length, ROUNDS)
        length = self._length[here, here]
        if math.isinf(length):
            self._last_count = 0
            return None
        self._last_count = trace(self._length, column, row, self._last)
        return Ways(np.where(np.isinf(self._length), length + NO_WAY_M, self._length), *offset)
