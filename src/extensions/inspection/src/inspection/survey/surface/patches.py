"""The surface in patches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from inspection.survey.surface.samples import SurfacePoints

INTO_AIR_M = 1e-3
"""A place counts to the cube this far before the surface, so that a wall on a border has one cube."""


@dataclass(frozen=True)
class Grid:
    """Cubes of the space; low: (3,) the first cube, size: (3,) their number, names: number of things."""

    side_m: float
    low: np.ndarray
    size: np.ndarray
    names: int

    def keys(self, points_m: np.ndarray, normals: np.ndarray, parts: np.ndarray) -> np.ndarray:
        """Return (n,) a number of cube, facing and thing; -1 outside."""
        cells = _cells(points_m, normals, self.side_m) - self.low
        facing = np.rint(1.5 * normals).astype(np.int64) + 2  # 5^3 directions at most
        key = (cells[:, 0] * self.size[1] + cells[:, 1]) * self.size[2] + cells[:, 2]
        key = ((key * 5 + facing[:, 0]) * 5 + facing[:, 1]) * 5 + facing[:, 2]
        inside = ((cells >= 0) & (cells < self.size)).all(axis=1)
        return np.where(inside, key * self.names + parts, -1)


def _cells(points_m: np.ndarray, normals: np.ndarray, side_m: float) -> np.ndarray:
    return np.floor((points_m + INTO_AIR_M * normals) / side_m).astype(np.int64)


@dataclass(frozen=True)
class Patches:
    """Pieces of the surface, each with one point for which it is judged.

    points_m: (n, 3) in the map's frame. normals: (n, 3) unit, to the air. areas_m2: (n,). parts: (n,) index
    of the name of the thing. names: of the things. grid: its cubes. keys: (n,) of the patches, ascending.
    """

    points_m: np.ndarray
    normals: np.ndarray
    areas_m2: np.ndarray
    parts: np.ndarray
    names: tuple[str, ...]
    grid: Grid
    keys: np.ndarray

    def __len__(self) -> int:
        return len(self.points_m)

    @property
    def by_part_m2(self) -> np.ndarray:
        """(names,) their area of each thing."""
        return np.bincount(self.parts, self.areas_m2, len(self.names))

    def only(self, those: np.ndarray) -> Patches:
        """Return these patches (n,) alone."""
        own = self.points_m[those], self.normals[those], self.areas_m2[those], self.parts[those]
        return Patches(*own, self.names, self.grid, self.keys[those])

    def numbers(self, points_m: np.ndarray, normals: np.ndarray, parts: np.ndarray) -> np.ndarray:
        """Return (k,) the patch that places (k, 3) on the surface belong to; -1: none."""
        keys = self.grid.keys(points_m, normals, parts)
        place = np.minimum(np.searchsorted(self.keys, keys), len(self.keys) - 1)
        return np.where(self.keys[place] == keys, place, -1)


def grouped(points: SurfacePoints, names: tuple[str, ...], side_m: float) -> Patches:
    """Return patches of points of a surface: of one thing, in one cube, that face about one way.

    A patch's point is the one nearest to the middle of its points.
    """
    points_m, normals, areas_m2, parts = points.points_m, points.normals, points.areas_m2, points.parts
    cells = _cells(points_m, normals, side_m)
    low = cells.min(axis=0)
    grid = Grid(side_m, low, cells.max(axis=0) + 1 - low, len(names))
    keys, of = np.unique(grid.keys(points_m, normals, parts), return_inverse=True)
    count = int(of.max()) + 1
    areas = np.bincount(of, areas_m2, count)

    def mean(values: np.ndarray) -> np.ndarray:
        sums = [np.bincount(of, areas_m2 * values[:, k], count) for k in range(3)]
        return np.stack(sums, axis=1) / areas[:, None]

    away = ((points_m - mean(points_m)[of]) ** 2).sum(axis=1)
    order = np.lexsort((away, of))
    first = order[np.searchsorted(of[order], np.arange(count))]
    towards = mean(normals)
    towards /= np.maximum(np.linalg.norm(towards, axis=1)[:, None], 1e-9)
    return Patches(points_m[first], towards, areas, parts[first], names, grid, keys)
