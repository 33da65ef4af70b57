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


class Plane(NamedTuple):
    """What a planar lidar knows."""

    points: np.ndarray
    """(n, 3) m: ends of the beams."""
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


def see_plane(
    cells: Cells, plane: Plane, motion: Motion, body: tuple[float, float, float], middle_m: float
) -> None:
    """Stamp what the lidar's plane shows: the tilted plane itself, and the body's height all along its beams.

    The latter is what flight in a plane assumes: what a beam passed is free at the height of flight. The
    UAV's own place is free, too. body: radius of that place, and ends of the body below and above, m.
    middle_m: height of the layer that the UAV is in, above the lidar. Cells count from there, so that a UAV
    cannot creep upwards by its own place.
    """
    i, j, k, x, y, z = cells.around(np.array(motion.position_m))
    h = np.hypot(x[None, :], y[:, None])
    bearing = np.arctan2(y[:, None], x[None, :])
    bins = np.rint(bearing * plane.seen.size / (2.0 * math.pi)).astype(int) % plane.seen.size
    radius, below, above = body
    rows, columns = np.nonzero((plane.seen[bins] > h + 0.5 * cells.edge_m) | (h < radius))
    half_m = 0.5 * cells.height_m
    is_level = (middle_m - below - half_m < z) & (z < middle_m + above + half_m)
    cells.stamps[i[rows, None], j[columns, None], k[is_level]] = motion.stamp_s
    normal = motion.rotation()[:, 2]
    tilted_m = -(normal[0] * x[columns] + normal[1] * y[rows]) / normal[2]
    level = np.floor((tilted_m - z[0]) / cells.height_m + 0.5).astype(int)
    inside = (level >= 0) & (level < z.size)
    cells.stamps[i[rows[inside]], j[columns[inside]], k[level[inside]]] = motion.stamp_s


def see_ranges(cells: Cells, rangings: Sequence[Ranging], motion: Motion, radius_m: float) -> None:
    """Stamp what range finders have passed, as wide as ``radius_m`` around their beams."""
    i, j, k, x, y, z = cells.around(np.array(motion.position_m))
    rotation = motion.rotation()
    for ranging in rangings:
        start, way = rotation @ ranging.origin_m, rotation @ ranging.direction
        along_m = (z - start[2]) / way[2] if way[2] else np.full(z.shape, math.inf)
        room_m = ranging.free_m - 0.5 * cells.height_m
        for level in np.flatnonzero((along_m >= -0.5 * cells.height_m) & (along_m <= room_m)):
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
    shaded = unseen[:, at[:, None], at]
    near = points[np.abs(points[:, 2]) < SHADING_M, :2]
    known = np.empty(distance.shape[1:])
    stamp(np.ascontiguousarray(near), known, cell_m, far_m)
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
