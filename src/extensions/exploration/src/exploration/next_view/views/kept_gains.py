"""What places show of the border (their information gain), kept until something in reach of them changes."""

from __future__ import annotations

import math

import numpy as np

from exploration.next_view.frontiers import Frontiers, ascending
from exploration.next_view.views.scene import Scene
from exploration.planning.space import Space

CUBE = 16
"""Voxels along a cube whose border is compared at once."""
PRIMES = np.array((73_856_093, 19_349_663, 83_492_791), np.int64)
"""Of a cell's place, so that no two cells look alike (Teschner et al., 2003)."""


class KeptGains:
    """Remembers what the places of the last decision show.

    A sum over all that is in reach of a place tells whether that may differ now.

    Args:
        cell_m: side of the cells.
    """

    def __init__(self, cell_m: float) -> None:
        self._cell_m = cell_m
        self._space: Space | None = None
        self._order = np.zeros(0, np.int64)
        self._keys, self._sums, self._gains = (np.zeros(0, np.int64) for _ in range(3))
        """Of the places of the last decision, by ascending keys."""

    def of(self, scene: Scene, places: np.ndarray, cells: Frontiers) -> np.ndarray:
        """Return (n,) the voxels that places (n, 3) of the map show of cells; -1: not known."""
        grid = scene.space.grid
        is_same_map = self._space is not None and self._space.grid is grid
        self._space = scene.space
        corner = grid.corner[::-1]
        reach = math.ceil(scene.sight.reaches[1] + self._cell_m / grid.resolution_m) + 2
        border = cells.places - 1 + corner
        marks = (border @ PRIMES) * (1 + cells.counts)
        low = np.floor_divide(corner - 1, CUBE)
        size = np.floor_divide(corner + np.array(grid.kinds.shape), CUBE) - low + 1
        in_cubes = np.zeros(size, np.int64)
        np.add.at(in_cubes, tuple((np.floor_divide(border, CUBE) - low).T), marks)
        whole = places + corner
        sums = _sums(in_cubes, low * CUBE, CUBE, whole, reach)
        sums += _sums(grid.versions, corner, grid.side, whole, reach)
        keys = ascending(whole)
        at = np.minimum(np.searchsorted(self._keys, keys), max(len(self._keys) - 1, 0))
        known = np.full(len(places), -1)
        if is_same_map and len(self._keys):
            is_kept = (self._keys[at] == keys) & (self._sums[at] == sums)
            known[is_kept] = self._gains[at[is_kept]]
        self._order = np.argsort(keys)
        self._keys, self._sums = keys[self._order], sums[self._order]
        return known

    def keep(self, gains: np.ndarray) -> None:
        """Keep what is known of the places (n,) of before; -1: nothing."""
        self._gains = gains[self._order]


def _sums(values: np.ndarray, first: np.ndarray, side: int, places: np.ndarray, reach: int) -> np.ndarray:
    """Return (n,) the sums over all cubes that come within reach of places (n, 3), along each axis.

    values: (d, h, w) of cubes of this side. first: (3,) the first voxel of the first one.
    """
    table = np.zeros(np.array(values.shape) + 1, np.int64)
    table[1:, 1:, 1:] = values.cumsum(0).cumsum(1).cumsum(2)
    low = np.clip((places - reach - first) // side, 0, values.shape)
    high = np.clip((places + reach - first) // side + 1, 0, values.shape)
    sums = np.zeros(len(places), np.int64)
    for z, y, x in np.ndindex(2, 2, 2):
        sign = -1 if (z + y + x) % 2 == 0 else 1
        sums += sign * table[(low, high)[z][:, 0], (low, high)[y][:, 1], (low, high)[x][:, 2]]
    return sums
