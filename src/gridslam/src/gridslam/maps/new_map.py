"""New maps: empty, from a given one, or from scans along a corrected path."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from gridslam.errors import MapError
from gridslam.maps.beams import beams_for_map
from gridslam.maps.tile_map import SCANS_AT_ONCE, TileMaps
from gridslam.occupancy_grid import UNKNOWN, OccupancyGrid
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan

BEAMS = 10
"""A known cell counts like one that this many beams have met."""
OCCUPIED_MIN = 65
"""Occupancy from which a cell of the given map is a wall (map_server's)."""
RESOLUTION_TOLERANCE = 1e-3


def check(grid: OccupancyGrid, delta_m: float) -> None:
    """Refuse a grid that cannot be the start of maps with cells of this size.

    Raises:
        MapError: the grid's cells are not of that size.
    """
    if abs(grid.resolution_m / delta_m - 1.0) > RESOLUTION_TOLERANCE:
        raise MapError(
            f"The starting map's cells are {grid.resolution_m:.6g} m wide; set delta to that, it is "
            f"{delta_m:.6g}."
        )


def insert(grid: OccupancyGrid, maps: TileMaps) -> None:
    """Enter a grid into the maps, which must be empty; all particles share its tiles.

    Raises:
        MapError: the grid's cells are not of the maps' size.
    """
    check(grid, maps.delta_m)
    known = grid.cells != UNKNOWN
    centres = grid.centres(known)
    if not len(centres):
        return
    maps.cover(centres.min(axis=0), centres.max(axis=0))
    cells = maps.to_cells(np.pad(centres, ((0, 0), (0, 1))))[:, :2]
    hits = np.where(grid.cells[known] >= OCCUPIED_MIN, BEAMS, 0)
    maps.enter(cells, hits, BEAMS)


def new_maps(grid: OccupancyGrid | None, particles: int, delta_m: float) -> TileMaps:
    """Return new maps of particles, made of a grid or empty (None)."""
    maps = TileMaps(particles, delta_m)
    if grid is not None:
        insert(grid, maps)
    return maps


class Band(NamedTuple):
    """Heights whose scans are in one map: half_m above and below the middle. NaN: all heights."""

    middle_m: float = math.nan
    half_m: float = math.nan

    def is_same(self, other: Band) -> bool:
        """Return whether both are of the same heights."""
        return self == other or (math.isnan(self.middle_m) and math.isnan(other.middle_m))


ALL_HEIGHTS = Band()


class MapDraft:
    """A map that is made anew, beside those in use, from scans along a corrected path.

    Args:
        parameters: the filter's.
        grid: the map begins with this; None: empty.
        first: index of the first scan that enters it.
        band: of the heights whose scans do.
    """

    def __init__(
        self, parameters: SlamParameters, grid: OccupancyGrid | None, first: int = 0, band: Band = ALL_HEIGHTS
    ):
        self.first, self.band, self._parameters = first, band, parameters
        self.maps = new_maps(grid, 1, parameters.delta)
        """Of one particle."""
        self.scans = first
        """Number of scans that have entered it, and of those that do not."""

    def add(self, poses_in_map: np.ndarray, scans: Sequence[PlanarScan | None]) -> None:
        """Enter the next scans, taken at these poses (k, 3). None: nothing is entered there."""
        self.add_beside(poses_in_map, scans)
        self.scans += len(poses_in_map)

    def add_beside(self, poses_in_map: np.ndarray, scans: Sequence[PlanarScan | None]) -> None:
        """Enter scans, taken at these poses (n, 3), that are not among those of the path's nodes."""
        for first in range(0, len(scans), SCANS_AT_ONCE):
            lot = slice(first, first + SCANS_AT_ONCE)
            self.maps.insert_path(poses_in_map[lot], beams_for_map(scans[lot], self._parameters))
