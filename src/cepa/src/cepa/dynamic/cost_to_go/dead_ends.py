"""Keeps dead ends closed, which look open again as soon as their back wall is out of sight."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cepa.dynamic.constants.cost_to_go import (
    DEAD_END_APART_M,
    DEAD_END_BEHIND_M,
    DEAD_END_CELLS,
    DEAD_END_S,
    DEAD_END_THICK_M,
    MOST_DEAD_ENDS,
)
from cepa.dynamic.cost_to_go.kernels.ways import cross_section


class Closing(NamedTuple):
    """A cross-section in the mouth of a dead end, which is closed."""

    cells: np.ndarray
    """(k, 2): column and row of its cells, among all cells of the plane."""
    until_s: float


class DeadEnds:
    """Cross-sections that a UAV closes behind itself while it leaves a dead end."""

    def __init__(self) -> None:
        self._cells = np.empty((DEAD_END_CELLS, 2), np.int64)
        self.reset()

    def reset(self) -> None:
        """Forget them."""
        self._closings: list[Closing] = []
        self._last_xy = (math.inf, math.inf)

    def are_any(self, stamp_s: float) -> bool:
        """Return whether any is closed."""
        return any(closing.until_s > stamp_s for closing in self._closings)

    def close(self, slowness: np.ndarray, column: int, row: int, stamp_s: float) -> None:
        """Close all cross-sections in ``slowness`` (n, n). column, row: of its middle among all cells."""
        half, n = len(slowness) // 2, len(slowness)
        self._closings = [closing for closing in self._closings if closing.until_s > stamp_s]
        for cells, _ in self._closings:
            columns, rows = (cells - (column - half, row - half)).T
            inside = (columns >= 0) & (columns < n) & (rows >= 0) & (rows < n)
            slowness[rows[inside], columns[inside]] = math.inf

    def leave(
        self,
        length: np.ndarray,
        slowness: np.ndarray,
        cell: tuple[int, int],
        place_xy: tuple[float, float],
        stamp_s: float,
    ) -> None:
        """Close a dead end behind a UAV at ``place_xy``, m, whose way does not begin towards the reference.

        length (n, n): of the way out from each cell, m; inf: there is none. slowness (n, n): as in
        `close`. cell: column and row there.
        """
        if math.dist(place_xy, self._last_xy) < DEAD_END_APART_M:
            return
        found = cross_section(
            length, slowness, DEAD_END_BEHIND_M, DEAD_END_BEHIND_M + DEAD_END_THICK_M, self._cells
        )
        if found:
            self._last_xy = place_xy
            self._closings.append(Closing(self._cells[:found] + np.array(cell), stamp_s + DEAD_END_S))
            self._closings = self._closings[-MOST_DEAD_ENDS:]
