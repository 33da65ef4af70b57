"""The distance fields of layers of heights, from points and from a planar scan."""

from __future__ import annotations

import numpy as np

from cepa.dynamic.constants.distance_fields import HEIGHT_ERROR_M, LAYERS, SHADING_M
from cepa.dynamic.constants.free_space import SEEN_CELL_M
from cepa.dynamic.free_space.planar_sensors import LidarPlane
from cepa.dynamic.kernels.distance_field import fill_distances
from cepa.dynamic.kernels.distance_layers import distance_layers, shade, squares_for
from cepa.dynamic.remembered.field_grid import field_grid_of
from cepa.parameters import CepaParameters


class LayeredField:
    """Fills one field (LAYERS, n, n), m: how near obstacles are. Each call of `of_points` overwrites it."""

    def __init__(self, parameters: CepaParameters):
        self._p = parameters
        self.grid = field_grid_of(parameters)
        self.far_m, side = parameters.r_ub + self.grid.cell_m, self.grid.side
        self._columns = np.empty((side, side), np.uint64)
        self._squares = squares_for(side, self.grid.cell_m, self.far_m)
        self._distance = np.empty((LAYERS, side, side))

    def of_points(self, points: np.ndarray, heights_m: np.ndarray) -> np.ndarray:
        """Return the distance to the nearest of points (m, 3), m, at heights (LAYERS,), m above the lidar."""
        p, around = self._p, 0.5 * self.grid.layer_m + HEIGHT_ERROR_M
        body = p.body_below + around, p.body_above + around
        grid = self.grid.cell_m, self.grid.layer_m
        middle_m = float(heights_m[LAYERS // 2])
        scratch = self._columns, self._squares
        distance_layers(points, middle_m, *grid, *body, self.far_m, *scratch, self._distance)
        return self._distance

    def shade(self, distance: np.ndarray, plane: LidarPlane, points: np.ndarray, unseen: np.ndarray) -> None:
        """Let what is known reach to all heights of ``distance`` (LAYERS, n, n), m, where nobody has looked.

        points (m, 3) m: what is remembered. unseen (LAYERS, k, k): where the body would be in what was not
        seen. In the middle layer what the plane shows always counts.
        """
        n, k = distance.shape[1], unseen.shape[1]
        finer = SEEN_CELL_M / self.grid.cell_m
        at = np.clip(np.floor((np.arange(n) - n // 2) / finer + 0.5).astype(int) + k // 2, 0, k - 1)
        near = points[np.abs(points[:, 2]) < SHADING_M, :2]
        known = np.empty(distance.shape[1:])
        fill_distances(np.ascontiguousarray(near), 0.0, 0.0, known, self.grid.cell_m, self.far_m)
        shade(distance, plane.distance[0], known, unseen, at, self.far_m)
