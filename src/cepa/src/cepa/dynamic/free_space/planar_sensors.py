"""What a planar scan and range finders show free in three dimensions, and the cells that they stamp."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from cepa.dynamic.free_space.kernels.planar import stamp_below_ranges, stamp_discs
from cepa.motion import Motion, Ranging


class LidarPlane(NamedTuple):
    """What a planar lidar knows."""

    free_m: np.ndarray
    """(bins,) m: how far each direction is free; -1 where no beam looks."""
    distance: np.ndarray
    """(1, n, n) m: to the nearest thing that stands, at whatever height it was seen."""


class Cells(NamedTuple):
    """The grid of cells that are stamped when they are seen; it repeats itself."""

    stamps: np.ndarray
    """(n, n, levels) s; indices y, x, z."""
    edge_m: float
    height_m: float

    def around(self, origin: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return the indices y, x, z of the window around ``origin``, and the places of its middles, m.

        The places are x (n,), y (n,) and z (levels,), relative to ``origin``.
        """
        (x, y, z), (n, _, levels) = origin.tolist(), self.stamps.shape
        columns, rows = (np.arange(n) + (math.floor(o / self.edge_m) - n // 2) for o in (x, y))
        heights = np.arange(levels) + (math.floor(z / self.height_m) - levels // 2)
        places = (columns + 0.5) * self.edge_m - x, (rows + 0.5) * self.edge_m - y
        return rows % n, columns % n, heights % levels, *places, (heights + 0.5) * self.height_m - z


class Body(NamedTuple):
    """What the UAV takes, m."""

    radius: float
    below: float
    above: float
    middle: float
    """Height of the layer that the UAV is in, above the lidar. The body's levels count from there, so that a
    UAV cannot creep upwards by its own place."""

    def levels(self, z: np.ndarray, height_m: float) -> np.ndarray:
        """Return which levels of cells with their middles at ``z`` (n,), m above the lidar, it is in (n,)."""
        half_m = 0.5 * height_m
        return (self.middle - self.below - half_m < z) & (z < self.middle + self.above + half_m)


def stamp_plane(cells: Cells, plane: LidarPlane, motion: Motion, body: Body) -> None:
    """Stamp what the lidar's plane shows: the tilted plane itself, and the body's height all along its beams.

    The latter is what flight in a plane assumes: what a beam passed is free at the height of flight.
    """
    i, j, k, x, y, z = cells.around(np.array(motion.position_m))
    is_body, normal = body.levels(z, cells.height_m), np.ascontiguousarray(motion.rotation()[:, 2])
    edges = cells.edge_m, cells.height_m
    stamp_below_ranges(cells.stamps, (i, j, k), x, y, z, edges, plane.free_m, is_body, normal, motion.stamp_s)


def stamp_ranges(
    cells: Cells, rangings: Sequence[Ranging], motion: Motion, body: Body, radius_m: float
) -> None:
    """Stamp what range finders have passed above and below the body, as wide as ``radius_m``."""
    if not rangings:
        return
    i, j, k, x, y, z = cells.around(np.array(motion.position_m))
    rotation, is_beside = motion.rotation(), ~body.levels(z, cells.height_m)
    for ranging in rangings:
        start, way = rotation @ ranging.origin_m, rotation @ ranging.direction
        along_m = (z - start[2]) / way[2] if way[2] else np.full(z.shape, math.inf)
        room_m = ranging.free_m - 0.5 * cells.height_m
        is_passed = is_beside & (along_m >= -0.5 * cells.height_m) & (along_m <= room_m)
        middles = start[:2] + np.where(is_passed, along_m, 0.0)[:, None] * way[:2]
        stamp_discs(cells.stamps, (i, j, k), x, y, middles, is_passed, radius_m, motion.stamp_s)


def cells_around(body: Body, radius_m: float, cells: Cells, motion: Motion) -> tuple[np.ndarray, ...]:
    """Return the indices y, x, z of the cells at the body's levels within ``radius_m`` of its middle."""
    i, j, k, x, y, z = cells.around(np.array(motion.position_m))
    reach = math.ceil(radius_m / cells.edge_m) + 1
    near = slice(max(0, len(x) // 2 - reach), len(x) // 2 + reach + 1)
    rows, columns = np.nonzero(np.hypot(x[near], y[near, None]) < radius_m)
    return i[near][rows, None], j[near][columns, None], k[body.levels(z, cells.height_m)]
