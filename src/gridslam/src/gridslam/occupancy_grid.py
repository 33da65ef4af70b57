"""An occupancy grid in ROS's form, for publishing, saving and as a starting map."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gridslam.errors import MapError

UNKNOWN, FREE, OCCUPIED = -1, 0, 100

CELLS_MAX = 420_000_000
"""Greatest number of cells of a map, each a byte: a square kilometre of cells of 5 cm, and its edges."""


@dataclass(frozen=True, eq=False)
class OccupancyGrid:
    """Cells that are unknown (-1), free (0) or occupied (100), or in between.

    Raises MapError when the parts do not make a map.
    """

    cells: np.ndarray
    """(h, w) int8; row 0 has the least y, column 0 the least x."""
    resolution_m: float
    """m: size of a cell."""
    origin_xy_m: tuple[float, float]
    """m: the lower left corner of cell [0, 0] in the map frame."""

    def __post_init__(self) -> None:
        cells = np.ascontiguousarray(self.cells, dtype=np.int8)
        if cells.ndim != 2:
            raise MapError(f"A map's cells must be a table, not an array of shape {cells.shape}.")
        if cells.size and not (cells.min() >= UNKNOWN and cells.max() <= OCCUPIED):
            raise MapError("A map's cells must be between -1 (unknown) and 100 (occupied).")
        if not 0.0 < self.resolution_m < math.inf:
            raise MapError(f"A map's resolution must be positive, not {self.resolution_m}.")
        origin = tuple(float(value) for value in self.origin_xy_m)
        if len(origin) != 2 or not all(math.isfinite(value) for value in origin):
            raise MapError(f"A map's origin must be finite x and y, not {origin}.")
        object.__setattr__(self, "cells", cells)
        object.__setattr__(self, "origin_xy_m", origin)

    @property
    def size_m(self) -> tuple[float, float]:
        """Width along x and height along y, m."""
        height, width = self.cells.shape
        return width * self.resolution_m, height * self.resolution_m

    def centres(self, mask: np.ndarray) -> np.ndarray:
        """Return the centres (n, 2), in m in the map frame, of the cells in a mask of the cells' shape."""
        rows, columns = np.nonzero(mask)
        return (np.stack((columns, rows), axis=1) + 0.5) * self.resolution_m + self.origin_xy_m

    def occupied_xy(self, least: int = 65) -> np.ndarray:
        """Return the centres (n, 2) of the cells of at least this occupancy."""
        return self.centres(self.cells >= least)
