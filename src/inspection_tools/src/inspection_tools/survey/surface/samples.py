"""Points spread evenly over triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

GOLDEN = np.array((0.7548776662466927, 0.5698402909980532))
"""Steps of the sequence that fills a square evenly (Roberts, 2018: R2)."""


@dataclass(frozen=True)
class Samples:
    """points_m: (n, 3). triangles: (n,) their indices. areas_m2: (n,) for which each stands."""

    points_m: np.ndarray
    triangles: np.ndarray
    areas_m2: np.ndarray


def normals_of(triangles_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the unit normals (m, 3) and the areas (m,) of triangles (m, 3, 3)."""
    across = np.cross(triangles_m[:, 1] - triangles_m[:, 0], triangles_m[:, 2] - triangles_m[:, 0])
    twice = np.linalg.norm(across, axis=1)
    return across / np.maximum(twice[:, None], 1e-15), 0.5 * twice


def samples_on(triangles_m: np.ndarray, spacing_m: float) -> Samples:
    """Return points on triangles, one for each spacing_m squared and at least one for each triangle."""
    _, areas_m2 = normals_of(triangles_m)
    numbers = np.maximum(np.ceil(areas_m2 / spacing_m**2).astype(np.int64), 1)
    of = np.repeat(np.arange(len(numbers)), numbers)
    order = np.arange(len(of)) - np.repeat(np.cumsum(numbers) - numbers, numbers)
    along = (0.5 + (order[:, None] + 1) * GOLDEN) % 1.0
    along[numbers[of] == 1] = 1.0 / 3.0
    folded = along.sum(axis=1) > 1.0
    along[folded] = 1.0 - along[folded]
    corners = triangles_m[of]
    points_m = (
        corners[:, 0]
        + along[:, :1] * (corners[:, 1] - corners[:, 0])
        + along[:, 1:] * (corners[:, 2] - corners[:, 0])
    )
    return Samples(points_m, of, (areas_m2 / numbers)[of])


def clipped(triangles_m: np.ndarray, low_m: np.ndarray, high_m: np.ndarray) -> np.ndarray:
    """Return which triangles (m,) reach into a box."""
    lowest, highest = triangles_m.min(axis=1), triangles_m.max(axis=1)
    return ((lowest <= high_m) & (highest >= low_m)).all(axis=1)
