"""Points spread evenly over triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

LARGE_M = 5.0
"""A triangle with a longer side that reaches out of a box is cut into parts."""
GOLDEN = np.array((0.7548776662466927, 0.5698402909980532))
"""Steps of the sequence that fills a square evenly (Roberts, 2018: R2)."""


@dataclass(frozen=True)
class Samples:
    """points_m: (n, 3). triangles: (n,) their indices. areas_m2: (n,) for which each stands."""

    points_m: np.ndarray
    triangles: np.ndarray
    areas_m2: np.ndarray


@dataclass(frozen=True)
class SurfacePoints:
    """Points spread evenly over the sides of a surface that are in the air.

    points_m: (n, 3). normals: (n, 3) unit, to the air. areas_m2: (n,) for which each stands. parts: (n,) the
    thing that it is on.
    """

    points_m: np.ndarray
    normals: np.ndarray
    areas_m2: np.ndarray
    parts: np.ndarray

    def __len__(self) -> int:
        return len(self.points_m)

    def only(self, those: np.ndarray) -> SurfacePoints:
        """Return these points (n,) alone."""
        return SurfacePoints(
            self.points_m[those], self.normals[those], self.areas_m2[those], self.parts[those]
        )


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


def samples_within(
    triangles_m: np.ndarray, spacing_m: float, low_m: np.ndarray, high_m: np.ndarray
) -> Samples:
    """Return points on triangles as `samples_on` does, but without most of those outside a box.

    Large triangles that reach out of it, such as the ground of a world, are cut into parts; parts outside are
    left out. So the memory goes by the surface in the box.
    """
    reaches = ((triangles_m.min(axis=1) < low_m) | (triangles_m.max(axis=1) > high_m)).any(axis=1)
    sides_m = np.linalg.norm(triangles_m[:, (1, 2, 0)] - triangles_m, axis=2).max(axis=1)
    is_cut = reaches & (sides_m > LARGE_M)
    parts, owners = [triangles_m[~is_cut]], [np.flatnonzero(~is_cut)]
    left, of = triangles_m[is_cut], np.flatnonzero(is_cut)
    while len(left):
        inside = clipped(left, low_m, high_m)
        left, of = left[inside], of[inside]
        sides_m = np.linalg.norm(left[:, (1, 2, 0)] - left, axis=2)
        is_small = sides_m.max(axis=1, initial=0.0) <= LARGE_M
        parts.append(left[is_small])
        owners.append(of[is_small])
        left, of = halved(left[~is_small]), np.tile(of[~is_small], 2)
    samples = samples_on(np.concatenate(parts), spacing_m)
    return Samples(samples.points_m, np.concatenate(owners)[samples.triangles], samples.areas_m2)


def halved(triangles_m: np.ndarray) -> np.ndarray:
    """Return the two halves of triangles, cut at their longest side: all first ones, then all second ones."""
    first = np.linalg.norm(triangles_m[:, (1, 2, 0)] - triangles_m, axis=2).argmax(axis=1)
    turn = (first[:, None] + np.arange(3)) % 3
    a, b, c = np.moveaxis(np.take_along_axis(triangles_m, turn[:, :, None], axis=1), 1, 0)
    middle = 0.5 * (a + b)
    return np.concatenate((np.stack((a, middle, c), axis=1), np.stack((middle, b, c), axis=1)))


def clipped(triangles_m: np.ndarray, low_m: np.ndarray, high_m: np.ndarray) -> np.ndarray:
    """Return which triangles (m,) reach into a box."""
    lowest, highest = triangles_m.min(axis=1), triangles_m.max(axis=1)
    return ((lowest <= high_m) & (highest >= low_m)).all(axis=1)
