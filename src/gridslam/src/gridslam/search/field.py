"""A map as a likelihood field: how well the end of a beam fits in each cell."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gridslam.kernels.places import FULL, squared_distances
from gridslam.occupancy_grid import UNKNOWN, OccupancyGrid

UNSEEN = 64
"""What fits in a cell that nobody has seen, of FULL."""
OCCUPIED_LEAST = 65
REACH_SIGMAS = 4.0
"""What is this many blurs off a surface does not fit at all: FULL exp(-4^2 / 2) rounds to 0."""


@dataclass(frozen=True, eq=False)
class LikelihoodField:
    """How well a point fits in each cell, 0 to FULL.

    On a surface it is FULL; d metres off it falls to FULL exp(-d^2 / (2 blur^2)). In space that was seen free
    it falls to 0, in unseen space to UNSEEN.

    Attributes:
        table: (h, w) uint8.
        origin_xy_m: (2,) the lower left corner of cell [0, 0].
        resolution_m: size of a cell.
        blur_m: standard deviation of the fall.
    """

    table: np.ndarray
    origin_xy_m: np.ndarray
    resolution_m: float
    blur_m: float

    @classmethod
    def from_masks(
        cls,
        occupied: np.ndarray,
        unseen: np.ndarray,
        origin_xy_m: np.ndarray,
        resolution_m: float,
        blur_m: float,
        pooled: int = 1,
    ) -> LikelihoodField:
        """Return the field of masks (h, w) bool: cells with a surface, and cells that were never seen.

        `pooled` x `pooled` cells of the masks become one of the field. Their squared distances are averaged.
        """
        pad = tuple((0, -side % pooled) for side in occupied.shape)
        occupied, unseen = np.pad(occupied, pad), np.pad(unseen, pad, constant_values=True)
        reach = math.ceil(REACH_SIGMAS * blur_m / resolution_m) + pooled
        sums = squared_distances(occupied, reach, pooled)
        mean = resolution_m**2 * (np.arange(pooled**2 * (reach + 1) ** 2 + 1) / pooled**2)
        fits = np.rint(FULL * np.exp(-0.5 * mean / blur_m**2)).astype(np.uint8)
        parts = [unseen[row::pooled, column::pooled] for row in range(pooled) for column in range(pooled)]
        is_unseen = np.logical_and.reduce(parts)
        table = np.maximum(fits[sums], np.where(is_unseen, np.uint8(UNSEEN), np.uint8(0)))
        return cls(table, np.array(origin_xy_m, float), pooled * resolution_m, blur_m)

    @classmethod
    def from_grid(cls, grid: OccupancyGrid, pooled: int = 2, blur_m: float = 0.1) -> LikelihoodField:
        """Return the field of a map, with `pooled` x `pooled` of its cells in one, to save time."""
        occupied, unseen = grid.cells >= OCCUPIED_LEAST, grid.cells == UNKNOWN
        return cls.from_masks(occupied, unseen, np.array(grid.origin_xy_m), grid.resolution_m, blur_m, pooled)
