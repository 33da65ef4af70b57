"""The best particle's map as an occupancy grid. Only changed tiles are drawn again."""

from __future__ import annotations

import numpy as np

from gridslam.kernels.rendering import render_changed
from gridslam.kernels.tiles import EMPTY, SIDE
from gridslam.maps.tile_map import TileMaps
from gridslam.occupancy_grid import UNKNOWN, OccupancyGrid
from gridslam.parameters import SlamParameters


class Renderer:
    """Keeps the last drawing, and the tiles that it shows."""

    def __init__(self, parameters: SlamParameters):
        self._parameters = parameters
        self._corner: np.ndarray | None = None
        self.drawn = 0
        """Tiles drawn by the last call."""

    def render(self, maps: TileMaps, particle: int) -> OccupancyGrid:
        """Return a particle's map: everything seen, and at least the box xmin to ymax."""
        self._cover_box(maps)
        maps.settle(particle)
        table = maps.tables[particle]
        if self._corner is None or table.shape != self._shown.shape or (self._corner != maps.corner).any():
            self._begin(maps, table.shape)
        threshold = self._parameters.occ_thresh
        self.drawn = render_changed(
            table, maps.pool.tiles, threshold, self._shown, self._stamps, self._canvas
        )
        return self._cut(maps, table)

    def _begin(self, maps: TileMaps, shape: tuple[int, int]) -> None:
        self._corner = maps.corner.copy()
        self._shown = np.full(shape, EMPTY, np.int32)
        self._stamps = np.zeros(shape, np.int64)
        self._canvas = np.full((shape[0] * SIDE, shape[1] * SIDE), UNKNOWN, np.int8)

    def _cover_box(self, maps: TileMaps) -> None:
        box = self._parameters.box
        if box is not None:
            maps.cover(box[:2], box[2:])

    def _cut(self, maps: TileMaps, table: np.ndarray) -> OccupancyGrid:
        """Return the part of the canvas to publish."""
        delta, box = self._parameters.delta, self._parameters.box
        ends = []
        seen = np.nonzero(table != EMPTY)
        if seen[0].size:
            ends.append([axis.min() * SIDE for axis in seen] + [(axis.max() + 1) * SIDE for axis in seen])
        if box is not None:
            sides = np.array(box)[[1, 0, 3, 2]] / delta
            ends.append(np.round(sides).astype(int) - np.tile(maps.corner[::-1] * SIDE, 2))
        if not ends:
            return OccupancyGrid(np.full((1, 1), UNKNOWN, np.int8), delta, (0.0, 0.0))
        low_row, low_column = (min(end[i] for end in ends) for i in (0, 1))
        high_row, high_column = (max(end[i] for end in ends) for i in (2, 3))
        cells = self._canvas[low_row:high_row, low_column:high_column].copy()
        origin = (maps.corner * SIDE + (low_column, low_row)) * delta
        return OccupancyGrid(cells, delta, tuple(origin.tolist()))
