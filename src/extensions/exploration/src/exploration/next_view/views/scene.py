"""What there is to see from places, for one decision."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exploration.next_view.frontiers import Frontiers, KnownBorder, in_cells
from exploration.next_view.kernels.views import seen_from
from exploration.next_view.parameters import ExplorerParameters
from exploration.next_view.unknown.leftovers import Sight
from exploration.planning.space import Space


@dataclass(frozen=True)
class Scene:
    """A map, the border of what is known in it, and what the lidar sees.

    space: what the UAV may fly through. kinds: of its voxels, with a layer around the map. border: (n, 3)
    frontier voxels of `kinds`.
    """

    space: Space
    kinds: np.ndarray
    border: np.ndarray
    sight: Sight

    @staticmethod
    def of(space: Space, parameters: ExplorerParameters, known: KnownBorder | None = None) -> Scene:
        """Return the scene of a space.

        known: the map and its border as they were. It is brought up to date, and scenes of before with it.
        """
        return Scene(space, *(known or KnownBorder()).of(space.grid), sight_of(space, parameters))

    def cells(self, side_m: float, which: np.ndarray | None = None) -> Frontiers:
        """Return the cells of the border, or of that part of it which a mask (n,) chooses."""
        border = self.border if which is None else self.border[which]
        return in_cells(border, self._voxels(side_m), self._corner)

    def keys(self, cells: Frontiers, side_m: float) -> np.ndarray:
        """Return (m, 3) numbers of cells that stay when the map grows."""
        keys: np.ndarray = (cells.places + self._corner) // self._voxels(side_m)
        return keys

    def gains(self, nodes: np.ndarray, cells: Frontiers) -> tuple[np.ndarray, np.ndarray]:
        """Return what nodes (n, 3) of the map show of cells, and which cells they see (m,)."""
        is_seen = np.zeros(len(cells.counts), bool)
        gains = seen_from(self.kinds, nodes + 1, *cells, *self.sight, is_seen)
        return gains, is_seen

    def _voxels(self, side_m: float) -> int:
        return max(1, round(side_m / self.space.grid.resolution_m))

    @property
    def _corner(self) -> np.ndarray:
        corner: np.ndarray = self.space.grid.corner[::-1] - 1
        return corner


def sight_of(space: Space, parameters: ExplorerParameters) -> Sight:
    """Return what the lidar sees in a space."""
    p, voxel_m = parameters, space.grid.resolution_m
    return Sight(p.slopes, (p.near / voxel_m, p.reach / voxel_m))
