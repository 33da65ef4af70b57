"""The best particle's map as an occupancy grid. Only changed tiles are drawn again."""

from __future__ import annotations

import numpy as np

from gridslam.kernels.rendering import render_changed
from gridslam.kernels.tiles import EMPTY, SIDE
from gridslam.maps.mapped_arrays import mapped_zeros
from gridslam.maps.tile_map import TileMaps
from gridslam.occupancy_grid import UNKNOWN, OccupancyGrid
from gridslam.parameters import SlamParameters


class Renderer:
    """Keeps the last drawing, and the tiles that it shows.

    The drawing covers what was seen. The table of tiles is larger, and a drawing of all of it would take
    memory. A returned map is the drawing of that time. Nobody changes it: the next one begins as a copy.
    """

    def __init__(self, parameters: SlamParameters):
        self._parameters = parameters
        self._corner = np.zeros(2, np.int64)
        """Row and column of the drawing's first tile, in tiles from the map's origin."""
        self._shown, self._stamps = np.zeros((0, 0), np.int32), np.zeros((0, 0), np.int64)
        self._canvas = np.zeros((0, 0), np.int8)
        self.drawn = 0
        """Tiles drawn by the last call."""

    def render(self, maps: TileMaps, particle: int) -> OccupancyGrid:
        """Return a particle's map: everything seen, and at least the box xmin to ymax."""
        if self._parameters.box is not None:
            maps.cover(self._parameters.box[:2], self._parameters.box[2:])
        maps.settle(particle)
        table, corner, delta = maps.tables[particle], maps.corner[::-1], self._parameters.delta
        ends = self._ends(table, corner)
        if ends is None:
            return OccupancyGrid(np.full((1, 1), UNKNOWN, np.int8), delta, (0.0, 0.0))
        self._begin(ends)
        low, threshold = self._corner - corner, self._parameters.occ_thresh
        high = low + self._shown.shape
        table = np.ascontiguousarray(table[low[0] : high[0], low[1] : high[1]])
        self.drawn = render_changed(
            table, maps.pool.tiles, threshold, self._shown, self._stamps, self._canvas
        )
        (low_row, low_column), (high_row, high_column) = ends - self._corner * SIDE
        cells = self._canvas[low_row:high_row, low_column:high_column]
        cells.flags.writeable = False
        return OccupancyGrid(cells, delta, tuple((ends[0, ::-1] * delta).tolist()))

    def _ends(self, table: np.ndarray, corner: np.ndarray) -> np.ndarray | None:
        """Return (2, 2): the first row and column to publish, and those after the last; None: there are none.

        They are in cells from the map's origin; ``corner`` (2,) is the table's, in tiles from there.
        """
        boxes, seen = [], np.argwhere(table != EMPTY)
        if len(seen):
            boxes.append(SIDE * np.add(corner, (seen.min(axis=0), seen.max(axis=0) + 1)))
        if self._parameters.box is not None:
            sides = np.array(self._parameters.box).reshape(2, 2)[:, ::-1] / self._parameters.delta
            boxes.append(np.round(sides).astype(int))
        if not boxes:
            return None
        return np.array([np.min(boxes, axis=0)[0], np.max(boxes, axis=0)[1]])

    def _begin(self, ends: np.ndarray) -> None:
        """Begin a drawing that covers these cells, too, with what the last one shows."""
        low, high = ends[0] // SIDE, -(-ends[1] // SIDE)
        old, corner = self._shown.shape, self._corner
        if self._shown.size:
            low, high = np.minimum(low, corner), np.maximum(high, corner + old)
        size = (int(high[0] - low[0]), int(high[1] - low[1]))
        canvas = mapped_zeros((size[0] * SIDE, size[1] * SIDE), np.int8)
        if size == old:
            canvas[:] = self._canvas
            self._canvas = canvas
            return
        canvas[:] = UNKNOWN
        shown, stamps = np.full(size, EMPTY, np.int32), np.zeros(size, np.int64)
        row, column = (int(value) for value in corner - low)
        if self._shown.size:
            for new, known, side in (
                (shown, self._shown, 1),
                (stamps, self._stamps, 1),
                (canvas, self._canvas, SIDE),
            ):
                new[row * side :, column * side :][: known.shape[0], : known.shape[1]] = known
        self._corner, self._shown, self._stamps, self._canvas = low, shown, stamps, canvas
