"""Remembers the mouths of dead ends, which look open again as soon as their back wall is out of sight."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cepa.kernels.field import cross_section

MOUTH_S = 120.0
"""For so long nobody tries the same dead end again."""
APART_M, MOST = 1.0, 40
"""The UAV closes a mouth behind itself each time that it has come so far; so many are kept."""
BEHIND_M, THICK_M = 2.5, 1.25
"""It is so far behind the UAV, by the length of the way, and so thick that no way leads through."""
MOST_CELLS = 400


class Mouth(NamedTuple):
    """A cross-section that is closed."""

    cells: np.ndarray
    """(k, 2): column and row of its cells, among all cells of the plane."""
    until_s: float


class Mouths:
    """Cross-sections that a UAV closes behind itself while it leaves a dead end."""

    def __init__(self) -> None:
        self._cells = np.empty((MOST_CELLS, 2), np.int64)
        self.reset()

    def reset(self) -> None:
        """Forget them."""
        self._mouths: list[Mouth] = []
        self._last_xy = (math.inf, math.inf)

    def are_any(self, stamp_s: float) -> bool:
        """Return whether any is closed."""
        return any(mouth.until_s > stamp_s for mouth in self._mouths)

    def close(self, slowness: np.ndarray, column: int, row: int, stamp_s: float) -> None:
        """Close the mouths in ``slowness`` (n, n). column, row: of its middle among all cells."""
        half, n = len(slowness) // 2, len(slowness)
        self._mouths = [mouth for mouth in self._mouths if mouth.until_s > stamp_s]
        for cells, _ in self._mouths:
            columns, rows = (cells - (column - half, row - half)).T
            inside = (columns >= 0) & (columns < n) & (rows >= 0) & (rows < n)
            slowness[rows[inside], columns[inside]] = math.inf

    def leave(
        self,
        way: np.ndarray,
        slowness: np.ndarray,
        cell: tuple[int, int],
        place_xy: tuple[float, float],
        stamp_s: float,
    ) -> None:
        """Close a mouth behind a UAV at ``place_xy``, m, whose way does not begin towards the reference.

        way (n, n): length of the way out from each cell, m; inf: there is none. slowness (n, n): as in
        `close`. cell: column and row there.
        """
        if math.dist(place_xy, self._last_xy) < APART_M:
            return
        found = cross_section(way, slowness, BEHIND_M, BEHIND_M + THICK_M, self._cells)
        if found:
            self._last_xy = place_xy
            self._mouths.append(Mouth(self._cells[:found] + np.array(cell), stamp_s + MOUTH_S))
            self._mouths = self._mouths[-MOST:]
