"""Plates: rectangles on planes that are fitted to points, each in a cell of the space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable, NamedTuple

import numpy as np

from flight_basics.checks import check_limits, limited
from gridslam.errors import ParameterError
from gridslam.volume.kernels.plates import planes_of_cells
from gridslam.volume.nodes import CloudNode

AHEAD = 0.8
"""Plates whose normals have a greater cosine between them face alike."""
SURE = 3
"""A plane with fewer points in its own cell fills a gap, or is none: the neighbours' points carry it."""


@dataclass(frozen=True)
class PlateParameters:
    """How plates are fitted.

    Raises:
        ParameterError: a value out of range.
    """

    cell: float = limited(0.2, above=0.0, below=1e4)
    """Side of a cell, m. Each plane has one plate in it."""
    reach: float = limited(0.12, above=0.0, below=1e4)
    """Points so far around a cell count for its planes, m."""
    off: float = limited(0.03, above=0.0, below=1e4)
    """Points are at most so far off their plane, m: the noise of lidar and poses."""
    thin: float = limited(0.05, above=0.0, below=1e4)
    """Points seen from about one side are averaged in cubes of this side, m."""
    gap: float = limited(0.05, above=0.0, below=1e4)
    """Plates reach over gaps of this width between points, m."""
    step: float = limited(0.05, above=0.0, below=1e4)
    """Corners of two plates this near are one, m."""
    tries: int = limited(32, 1, 9999)
    """Planes that are tried for each."""

    def __post_init__(self) -> None:
        check_limits(self, ParameterError, "{} of plates")
        if self.reach > self.cell:
            raise ParameterError(
                f"reach of plates must be at most the cell of {self.cell} m, not {self.reach}."
            )


@dataclass(frozen=True)
class Plates:
    """Rectangles in the map's frame.

    corners_m: (n, 4, 3) anticlockwise, seen from the front. normals: (n, 3) unit, to the front.
    """

    corners_m: np.ndarray
    normals: np.ndarray

    def __len__(self) -> int:
        return len(self.corners_m)

    @property
    def centres_m(self) -> np.ndarray:
        """(n, 3) their middles."""
        return self.corners_m.mean(axis=1)

    def only(self, those: np.ndarray) -> Plates:
        """Return these (n,) alone."""
        return Plates(self.corners_m[those], self.normals[those])


class SeenPoints(NamedTuple):
    """places_m: (n, 3) in the map. ways: (n, 3) unit, to their sensors. weights: (n,) of each."""

    places_m: np.ndarray
    ways: np.ndarray
    weights: np.ndarray


def plates_of(
    points: SeenPoints, rng: np.random.Generator, parameters: PlateParameters | None = None
) -> Plates:
    """Return the plates of points."""
    p = parameters or PlateParameters()
    points_m, ways, weights = points
    order, cells, begins = _sorted(points_m, p.cell)
    rows = planes_of_cells(
        cells, begins, points_m[order], ways[order], weights[order], rng.random((p.tries, 3)),
        p.cell, p.reach, p.off,
    )  # fmt: skip
    cells = cells[rows[:, 0].astype(np.int64)]
    return _rectangles(cells, rows[:, 1:4], rows[:, 4:7], rows[:, 7:10], rows[:, 10:13], rows[:, 13], p)


def points_of(nodes: Iterable[CloudNode], parameters: PlateParameters | None = None) -> SeenPoints:
    """Return the points of the clouds of a path's nodes, where they are in the map.

    Points of a cube that were seen from the same octant are one, so that the two sides of a thin plate stay
    apart. Poses are off by an angle, so a point's weight falls with the square of its distance.
    """
    side_m = (parameters or PlateParameters()).thin
    keys, sums = [], []
    for node in nodes:
        pose = node.sensor_in_map
        points = node.cloud.points().astype(float) @ pose.rotation.T
        range_m = np.maximum(np.linalg.norm(points, axis=1), 1e-3)
        ways = -points / range_m[:, None]
        places = points + pose.translation
        weights = 1.0 / np.maximum(range_m, 1.0) ** 2
        cubes = np.floor(places / side_m).astype(np.int64) + (1 << 19)
        octant = (ways > 0.0) @ np.array((1, 2, 4))
        keys.append((((cubes[:, 0] << 20) + cubes[:, 1] << 20) + cubes[:, 2] << 3) + octant)
        sums.append(np.column_stack((places, ways, np.ones(len(places)))) * weights[:, None])
    if not keys:
        return SeenPoints(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
    key, rows = np.concatenate(keys), np.concatenate(sums)
    _, of = np.unique(key, return_inverse=True)
    count = int(of.max()) + 1
    total = np.column_stack([np.bincount(of, rows[:, k], count) for k in range(7)])
    means = total[:, :6] / total[:, 6:]
    ways = means[:, 3:] / np.maximum(np.linalg.norm(means[:, 3:], axis=1), 1e-9)[:, None]
    return SeenPoints(means[:, :3], ways, total[:, 6])


def _sorted(points_m: np.ndarray, side_m: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the order (n,) of the points by cell, the cells (m, 3), and where each one's points begin."""
    cells = np.floor(points_m / side_m).astype(np.int64)
    order = np.lexsort((cells[:, 2], cells[:, 1], cells[:, 0]))
    cells = cells[order]
    is_first = np.append(True, (cells[1:] != cells[:-1]).any(axis=1))[: len(cells)]
    begins = np.flatnonzero(is_first)
    return order, cells[begins], np.append(begins, len(cells))


def _rectangles(
    cells: np.ndarray, normals: np.ndarray, places_m: np.ndarray, low_m: np.ndarray, high_m: np.ndarray,
    own: np.ndarray, p: PlateParameters,
) -> Plates:  # fmt: skip
    """Return what the planes have in their cells, along their steepest axes; neighbours' corners meet."""
    along = np.argmax(np.abs(normals), axis=1)
    row = np.arange(len(cells))
    sign = np.sign(normals[row, along])
    u, v = (along + 1) % 3, (along + 2) % 3
    sides, at_border = [], []
    for axis in (u, v):
        first, last = cells[row, axis] * p.cell, (cells[row, axis] + 1) * p.cell
        low, high = low_m[row, axis] - 0.5 * p.gap, high_m[row, axis] + 0.5 * p.gap
        reaches = low <= first + 0.5 * p.gap, high >= last - 0.5 * p.gap
        sides.append((np.where(reaches[0], first, low), np.where(reaches[1], last, high)))
        at_border.append(reaches)
    slope_u, slope_v = -normals[row, u] / normals[row, along], -normals[row, v] / normals[row, along]

    def height(at_u: np.ndarray, at_v: np.ndarray) -> np.ndarray:
        return (
            places_m[row, along] + slope_u * (at_u - places_m[row, u]) + slope_v * (at_v - places_m[row, v])
        )

    there_m = height(*(0.5 * (low + high) for low, high in sides))
    kept = _is_single(cells, normals, along, np.floor(there_m / p.cell).astype(np.int64), own >= SURE)
    kept &= (sides[0][1] > sides[0][0]) & (sides[1][1] > sides[1][0])
    corners = np.zeros((len(cells), 4, 3))
    keys = np.full((len(cells), 4), -1, np.int64)
    for k, (i, j) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
        at_u, at_v = sides[0][i], sides[1][j]
        corners[row, k, u], corners[row, k, v] = at_u, at_v
        corners[row, k, along] = height(at_u, at_v)
        whole = at_border[0][i] & at_border[1][j] & kept
        place = (cells[row, u] + i + (1 << 18) << 20) + cells[row, v] + j + (1 << 18)
        keys[:, k] = np.where(whole, (place << 3) + along * 2 + (sign > 0), -1)
    _weld(corners, keys, along, p.step)
    back = (sign < 0)[:, None, None]
    corners = np.where(back, corners[:, ::-1], corners)
    return Plates(corners[kept], normals[kept])


def _is_single(
    cells: np.ndarray, normals: np.ndarray, along: np.ndarray, there: np.ndarray, is_sure: np.ndarray
) -> np.ndarray:
    """Return which planes (n,) are no copies: a sure one of another in its cell, an unsure one of any beside.

    there: (n,) the cell, of those in a row along the plane's axis, in which its plate lies.
    """
    homes: dict[tuple[int, ...], list[int]] = {}
    kept = np.zeros(len(cells), bool)
    is_home = there == cells[np.arange(len(cells)), along]
    for k in np.lexsort((~is_home, ~is_sure)).tolist():
        step = np.eye(3, dtype=np.int64)[along[k]]
        cell = cells[k] + (there[k] - cells[k, along[k]]) * step
        others = []
        if not is_sure[k]:
            others = [n for beside in (cell - step, cell, cell + step) for n in homes.get(tuple(beside), ())]
        elif not is_home[k]:
            others = [n for n in homes.get(tuple(cell), ()) if along[n] == along[k]]
        if not any(normals[n] @ normals[k] >= AHEAD for n in others):
            homes.setdefault(tuple(cell), []).append(k)
            kept[k] = True
    return kept


def _weld(corners_m: np.ndarray, keys: np.ndarray, along: np.ndarray, step_m: float) -> None:
    """Let corners (n, 4, 3) with the same key (n, 4) have their mean height if they are so near; -1: none."""
    which = np.argwhere(keys >= 0)
    if not len(which):
        return
    axis = along[which[:, 0]]
    heights = corners_m[which[:, 0], which[:, 1], axis]
    key = keys[which[:, 0], which[:, 1]]
    order = np.lexsort((heights, key))
    key, sorted_m = key[order], heights[order]
    is_first = np.append(True, (key[1:] != key[:-1]) | (np.diff(sorted_m) > step_m))
    of = np.cumsum(is_first) - 1
    means = np.bincount(of, sorted_m) / np.bincount(of)
    heights[order] = means[of]
    corners_m[which[:, 0], which[:, 1], axis] = heights
