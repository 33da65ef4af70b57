"""Heights for a UAV whose lidar sees one plane: what that plane and range finders up and down have seen.

Axes are those of the odometry's frame, with the lidar at the origin. The stamps of cells are those of
`CloudLookout`.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from cepa.kernels.field import stamp
from cepa.motion import Motion, Ranging

LONGEST_SEARCH_M = 5.0
"""So far above and below the height where it began it looks for a way."""


SHADING_M = 1.0
"""What is so much higher or lower than the lidar, such as the floor, does not reach to other heights."""


OWN_PLACE_BINS = 360
_angles = 2.0 * math.pi / OWN_PLACE_BINS * np.arange(OWN_PLACE_BINS)
OWN_PLACE_DIRECTIONS = np.stack((np.cos(_angles), np.sin(_angles)))


class Plane(NamedTuple):
    """What a planar lidar knows."""

    seen: np.ndarray
    """(bins,) m: how far each direction is seen; -1 where no beam looks."""
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


def see_plane(cells: Cells, plane: Plane, motion: Motion, body: Body) -> None:
    """Stamp what the lidar's plane shows: the tilted plane itself, and the body's height all along its beams.

    The latter is what flight in a plane assumes: what a beam passed is free at the height of flight.
    """
    i, j, k, x, y, z = cells.around(np.array(motion.position_m))
    h = np.hypot(x[None, :], y[:, None])
    bearing = np.arctan2(y[:, None], x[None, :])
    bins = np.rint(bearing * plane.seen.size / (2.0 * math.pi)).astype(int) % plane.seen.size
    rows, columns = np.nonzero(plane.seen[bins] > h + 0.5 * cells.edge_m)
    levels = k[body.levels(z, cells.height_m)]
    cells.stamps[i[rows, None], j[columns, None], levels] = motion.stamp_s
    normal = motion.rotation()[:, 2]
    tilted_m = -(normal[0] * x[columns] + normal[1] * y[rows]) / normal[2]
    level = np.floor((tilted_m - z[0]) / cells.height_m + 0.5).astype(int)
    inside = (level >= 0) & (level < z.size)
    cells.stamps[i[rows[inside]], j[columns[inside]], k[level[inside]]] = motion.stamp_s


class OwnPlace:
    """A disc that the UAV's middle may not leave where nobody has looked, such as where it started.

    It lies where the UAV was last within what had been seen. From there only drift can drag it along. If it
    went with the UAV, the UAV would creep into what its lidar does not see.
    """

    def __init__(self, radius_m: float) -> None:
        self._radius_m = radius_m
        self._xy: np.ndarray | None = None

    def follow(self, here: np.ndarray, is_seen: bool) -> np.ndarray:
        """Return how far the UAV may go in each of OWN_PLACE_BINS directions, m.

        here: (2,) m, along the odometry's axes. is_seen: whether all that the body takes was seen.
        """
        if self._xy is None or is_seen:
            self._xy = here
        back = self._xy - here
        back *= min(1.0, self._radius_m / max(math.hypot(*back), 1e-9))
        self._xy = here + back
        along = back @ OWN_PLACE_DIRECTIONS
        return along + np.sqrt(np.maximum(0.0, self._radius_m**2 - back @ back + along**2))


def place_of(body: Body, radius_m: float, cells: Cells, motion: Motion) -> tuple[np.ndarray, ...]:
    """Return the indices y, x, z of the cells at the body's levels within ``radius_m`` of its middle."""
    i, j, k, x, y, z = cells.around(np.array(motion.position_m))
    rows, columns = np.nonzero(np.hypot(x, y[:, None]) < radius_m)
    return i[rows, None], j[columns, None], k[body.levels(z, cells.height_m)]


def see_ranges(
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


def ends_of(rangings: Sequence[Ranging], motion: Motion, below_m: float, above_m: float) -> np.ndarray:
    """Return where range finders met something (n, 3), m.

    What is at the body already, between ``below_m`` under and ``above_m`` over the lidar, is left out: it is
    the floor that the UAV stands on, or a hand.
    """
    rotation = motion.rotation()
    ends = [
        rotation @ (np.array(ranging.origin_m) + ranging.range_m * np.array(ranging.direction))
        for ranging in rangings
        if ranging.range_min_m <= ranging.range_m <= ranging.range_max_m
    ]
    ends = [end for end in ends if not -below_m <= end[2] <= above_m]
    return np.array(ends).reshape(-1, 3)


def shade(
    distance: np.ndarray,
    plane: Plane,
    points: np.ndarray,
    unseen: np.ndarray,
    cell_m: float,
    finer: float,
    far_m: float,
) -> None:
    """Let what is known reach to all heights where nobody has looked: write it into ``distance``.

    distance (layers, n, n) m, at most ``far_m``, in cells of ``cell_m``. points (m, 3) m: what is remembered.
    unseen (layers, k, k): where the body would be in what was not seen; a cell of it is ``finer`` times as
    wide as one of ``distance``. In the middle layer what the plane shows always counts.
    """
    n, k = distance.shape[1], unseen.shape[1]
    at = np.clip(np.floor((np.arange(n) - n // 2) / finer + 0.5).astype(int) + k // 2, 0, k - 1)
    shaded = unseen[:, at[:, None], at] != 0
    near = points[np.abs(points[:, 2]) < SHADING_M, :2]
    known = np.empty(distance.shape[1:])
    stamp(np.ascontiguousarray(near), 0.0, 0.0, known, cell_m, far_m)
    np.minimum(distance, np.minimum(plane.distance, known), out=distance, where=shaded)
    middle = distance[len(distance) // 2]
    np.minimum(middle, plane.distance[0], out=middle)


class HeightSearch:
    """Where the plane has no way out, tries the heights above, then those below."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Begin anew: a way was found."""
        self._untried = [1.0, -1.0]
        self._began_m: float | None = None

    def climb(self, height_m: float, is_open: tuple[bool, bool]) -> float | None:
        """Return 1.0 to climb, -1.0 to sink, or None when both were tried.

        height_m: of the UAV. is_open: whether it may move into the next layer above, and below.
        """
        if self._began_m is None:
            self._began_m = height_m
        while self._untried:
            sign = self._untried[0]
            if is_open[0 if sign > 0.0 else 1] and sign * (height_m - self._began_m) < LONGEST_SEARCH_M:
                return sign
            self.give_up()
        return None

    def give_up(self) -> None:
        """Try the other direction, if it was not tried before."""
        del self._untried[:1]
