"""Which cells are open, and what a metre costs in them: by the distance to obstacles, with a hysteresis."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.cost_to_go import (
    CLOSED_M,
    GIVEN_UP_M,
    HYSTERESIS_M,
    NARROW_M,
    NARROWER_M,
    PAUSE_S,
    SLOW_NARROW,
    STALL_M,
    STALL_S,
    STAY_CELLS,
    STAY_S,
    WAY_CELL_M,
)
from cepa.dynamic.cost_to_go.kernels.slowness import fill_slowness
from cepa.dynamic.cost_to_go.place import Place
from cepa.motion import Motion
from cepa.parameters import CepaParameters

GIVEN_UP_UNTIL = 2
"""Column of a cell's state."""


class Openings:
    """Keeps each cell's state: whether it was closed, when, and until when it is given up.

    A UAV that has got nowhere for STALL_S gives up what is narrow in its way ahead.
    """

    def __init__(self, parameters: CepaParameters, side: int):
        """side: cells of the window along an edge."""
        self._p = parameters
        self._states = np.empty((side + STAY_CELLS, side + STAY_CELLS, 3))
        self._limits_m = parameters.r_lb + CLOSED_M + HYSTERESIS_M * np.array([-1.0, 0.0, 1.0])
        self.reset()

    def reset(self) -> None:
        """Forget all states."""
        self._states[:] = -math.inf
        self._stayed_xy, self._stayed_since_s = (math.inf, math.inf), math.inf
        self._asked_s = -math.inf

    def take_over(self, earlier: Openings) -> None:
        """Take over what was open from one with a window of the same size."""
        self._states, self._asked_s = earlier._states, earlier._asked_s
        self._stayed_xy, self._stayed_since_s = earlier._stayed_xy, earlier._stayed_since_s

    def has_same_size(self, other: Openings) -> bool:
        """Return whether the windows have the same size."""
        return self._states.shape == other._states.shape

    def slowness(self, distance: np.ndarray, place: Place, stamp_s: float) -> np.ndarray:
        """Return the cost of a metre in each cell (n, n); inf: closed.

        distance (n, n): m, to what is around.
        """
        p, slowness = self._p, np.empty_like(distance)
        cushions, cell = (float(p.r_lb), float(p.r_ub)), (place.column, place.row)
        fill_slowness(distance, self._limits_m, *cushions, *cell, stamp_s, STAY_S, self._states, slowness)
        return slowness

    def with_narrow(
        self, slowness: np.ndarray, distance: np.ndarray, place: Place, stamp_s: float
    ) -> np.ndarray:
        """Return ``slowness`` (n, n) where openings with NARROWER_M less room are passable, but slow."""
        n, m = len(slowness), len(self._states)
        rows, columns = ((k + np.arange(n) - n // 2) % m for k in (place.row, place.column))
        is_given_up = self._states[np.ix_(rows, columns)][:, :, GIVEN_UP_UNTIL] > stamp_s
        least_m = self._p.r_lb - NARROWER_M
        return np.where(np.isinf(slowness) & (distance >= least_m) & ~is_given_up, SLOW_NARROW, slowness)

    def give_up_if_stalled(
        self, motion: Motion, distance: np.ndarray, place: Place, way_cells: np.ndarray
    ) -> None:
        """Close what is narrow in the way ahead for memory_s if the UAV has got nowhere for long.

        distance (n, n): m, to what is around. way_cells (k, 2): columns and rows of the last way.
        """
        x_m, y_m, _ = motion.position_m
        paused_s, self._asked_s = motion.stamp_s - self._asked_s, motion.stamp_s
        went_on = math.dist((x_m, y_m), self._stayed_xy) > STALL_M
        if went_on or not 0.0 <= paused_s <= PAUSE_S:
            self._stayed_xy, self._stayed_since_s = (x_m, y_m), motion.stamp_s
        if motion.stamp_s - self._stayed_since_s < STALL_S:
            return
        self._stayed_since_s = motion.stamp_s
        half, cells = len(distance) // 2, len(self._states)
        for way_column, way_row in way_cells[: round(GIVEN_UP_M / WAY_CELL_M)]:
            i, j = way_row - place.row + half, way_column - place.column + half
            if distance[i, j] < self._p.r_lb + NARROW_M:
                rows, columns = ((k + np.arange(-1, 2)) % cells for k in (way_row, way_column))
                until = np.ix_(rows, columns, [GIVEN_UP_UNTIL])
                self._states[until] = motion.stamp_s + self._p.memory_s

    def reopen(self) -> None:
        """Take back what was given up, because there is no way at all."""
        self._states[:, :, GIVEN_UP_UNTIL] = -math.inf
