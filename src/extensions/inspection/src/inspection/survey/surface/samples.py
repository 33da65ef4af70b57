"""Points spread evenly over triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator

import numpy as np

LARGE_M = 5.0
"""A triangle with a longer side that reaches out of a box is cut into parts."""
AT_ONCE = 500_000
"""Points, of some 100 bytes while they are computed."""
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


def samples_within(
    triangles_m: np.ndarray, spacing_m: float, low_m: np.ndarray, high_m: np.ndarray
) -> Samples:
    """Return points on triangles (m, 3, 3), one for each spacing_m squared and at least one for each of them.

    Most of those outside a box are left out: large triangles that reach out of it, such as the ground of a
    world, are cut into parts, and parts outside do not count. So the memory goes by the surface in the box.
    """
    several = list(samples_in_turn(triangles_m, spacing_m, low_m, high_m))
    return Samples(
        np.concatenate([each.points_m for each in several]),
        np.concatenate([each.triangles for each in several]),
        np.concatenate([each.areas_m2 for each in several]),
    )


def samples_in_turn(
    triangles_m: np.ndarray, spacing_m: float, low_m: np.ndarray, high_m: np.ndarray
) -> Iterator[Samples]:
    """Yield the points of `samples_within`, `AT_ONCE` of them at a time, and once at least."""
    parts_m, owners = _parts_within(triangles_m, low_m, high_m)
    _, areas_m2 = normals_of(parts_m)
    numbers = np.maximum(np.ceil(areas_m2 / spacing_m**2).astype(np.int64), 1)
    ends, total = np.cumsum(numbers), int(numbers.sum())
    for begin in range(0, max(total, 1), AT_ONCE):
        points = np.arange(begin, min(begin + AT_ONCE, total))
        of = np.searchsorted(ends, points, side="right")
        along = (0.5 + (points - ends[of] + numbers[of] + 1)[:, None] * GOLDEN) % 1.0
        along[numbers[of] == 1] = 1.0 / 3.0
        folded = along.sum(axis=1) > 1.0
        along[folded] = 1.0 - along[folded]
        a, b, c = np.moveaxis(parts_m[of], 1, 0)
        points_m = a + along[:, :1] * (b - a) + along[:, 1:] * (c - a)
        yield Samples(points_m, owners[of], (areas_m2 / numbers)[of])


def _parts_within(
    triangles_m: np.ndarray, low_m: np.ndarray, high_m: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return triangles and parts of them (k, 3, 3), and of which triangle each (k,) is."""
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
    return np.concatenate(parts), np.concatenate(owners)


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
