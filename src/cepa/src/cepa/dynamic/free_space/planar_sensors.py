"""What a planar scan and range finders show free in three dimensions, and the cells that they stamp."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

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
        n, levels = self.stamps.shape[0], self.stamps.shape[2]
        edges = np.array([self.edge_m, self.edge_m, self.height_m])
        counts = np.array([n, n, levels])
        first = np.floor(origin / edges).astype(int) - counts // 2
        columns, rows, heights = (np.arange(low, low + count) for low, count in zip(first, counts))
        x, y, z = (
            (cells + 0.5) * edge - o for cells, edge, o in zip((columns, rows, heights), edges, origin)
        )
        return rows % n, columns % n, heights % levels, x, y, z


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
    h = np.hypot(x[None, :], y[:, None])
    bearing = np.arctan2(y[:, None], x[None, :])
    bins = np.rint(bearing * plane.free_m.size / (2.0 * math.pi)).astype(int) % plane.free_m.size
    rows, columns = np.nonzero(plane.free_m[bins] > h + 0.5 * cells.edge_m)
    levels = k[body.levels(z, cells.height_m)]
    cells.stamps[i[rows, None], j[columns, None], levels] = motion.stamp_s
    normal = motion.rotation()[:, 2]
    tilted_m = -(normal[0] * x[columns] + normal[1] * y[rows]) / normal[2]
    level = np.floor((tilted_m - z[0]) / cells.height_m + 0.5).astype(int)
    inside = (level >= 0) & (level < z.size)
    cells.stamps[i[rows[inside]], j[columns[inside]], k[level[inside]]] = motion.stamp_s


def stamp_ranges(
    cells: Cells, rangings: Sequence[Ranging], motion: Motion, body: Body, radius_m: float
) -> None:
    """Stamp what range finders have passed above and below the body, as wide as ``radius_m``."""
    i, j, k, x, y, z = cells.around(np.array(motion.position_m))
    rotation, is_beside = motion.rotation(), ~body.levels(z, cells.height_m)
    for ranging in rangings:
        start, way = rotation @ ranging.origin_m, rotation @ ranging.direction
        along_m = (z - start[2]) / way[2] if way[2] else np.full(z.shape, math.inf)
        room_m = ranging.free_m - 0.5 * cells.height_m
        is_passed = is_beside & (along_m >= -0.5 * cells.height_m) & (along_m <= room_m)
        for level in np.flatnonzero(is_passed):
            at = start + along_m[level] * way
            rows, columns = np.nonzero(np.hypot(x[None, :] - at[0], y[:, None] - at[1]) < radius_m)
            cells.stamps[i[rows], j[columns], k[level]] = motion.stamp_s


def cells_around(body: Body, radius_m: float, cells: Cells, motion: Motion) -> tuple[np.ndarray, ...]:
    """Return the indices y, x, z of the cells at the body's levels within ``radius_m`` of its middle."""
    i, j, k, x, y, z = cells.around(np.array(motion.position_m))
    rows, columns = np.nonzero(np.hypot(x, y[:, None]) < radius_m)
    return i[rows, None], j[columns, None], k[body.levels(z, cells.height_m)]
