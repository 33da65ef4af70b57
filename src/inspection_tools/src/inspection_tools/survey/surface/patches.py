"""The surface in patches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Patches:
    """Pieces of the surface, each with one point for which it is judged.

    points_m: (n, 3) in the map's frame. normals: (n, 3) unit, to the air. areas_m2: (n,). parts: (n,) index
    of the name of the thing. names: of the things.
    """

    points_m: np.ndarray
    normals: np.ndarray
    areas_m2: np.ndarray
    parts: np.ndarray
    names: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.points_m)


def grouped(
    points_m: np.ndarray,
    normals: np.ndarray,
    areas_m2: np.ndarray,
    parts: np.ndarray,
    names: tuple[str, ...],
    side_m: float,
) -> Patches:
    """Return patches of samples (n, 3): of one thing, in one cube, that face about one way.

    A patch's point is the sample nearest to the middle of its samples.
    """
    facing = np.rint(1.5 * normals).astype(np.int64) + 2  # 5^3 directions at most
    cells = np.floor(points_m / side_m + 1e-6).astype(np.int64)
    cells -= cells.min(axis=0)
    size = cells.max(axis=0) + 1
    key = (cells[:, 0] * size[1] + cells[:, 1]) * size[2] + cells[:, 2]
    key = ((key * 5 + facing[:, 0]) * 5 + facing[:, 1]) * 5 + facing[:, 2]
    key = key * len(names) + parts
    _, of = np.unique(key, return_inverse=True)
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
    return Patches(points_m[first], towards, areas, parts[first], names)
