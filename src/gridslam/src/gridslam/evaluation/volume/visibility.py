"""What a lidar could see from where it was, by rays."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable

import numpy as np

from gridslam.errors import EvaluationError
from gridslam.evaluation.volume.surface import Samples, Surface

OFF_SURFACE_M = 0.01
"""A ray that ends this near to a point has reached it."""


@dataclass(frozen=True)
class LidarView:
    """What a lidar's beams reach. A lidar that nods or leans sees through its places' attitudes.

    Raises:
        EvaluationError: a bound makes no sense.
    """

    elevation_deg: tuple[float, float] = (-90.0, 90.0)
    """Lowest and highest beam, from the lidar's plane."""
    range_max_m: float = 30.0
    incidence_max_deg: float = 80.0
    """A surface that beams graze at a greater angle from its normal counts as one that could not be seen."""

    def __post_init__(self) -> None:
        low, high = self.elevation_deg
        if not -90.0 <= low < high <= 90.0:
            raise EvaluationError(f"Elevations of {low:g} to {high:g} deg: use -90 <= LOW < HIGH <= 90.")
        if not 0.0 < self.range_max_m < math.inf:
            raise EvaluationError(f"The greatest range is {self.range_max_m:g} m. Give a length above 0.")
        if not 0.0 < self.incidence_max_deg <= 90.0:
            raise EvaluationError(f"The greatest incidence is {self.incidence_max_deg:g} deg. Use 0 to 90.")


@dataclass(frozen=True)
class Places:
    """Where the lidar was: positions_m (n, 3) and rotations (n, 3, 3), lidar to world."""

    positions_m: np.ndarray
    rotations: np.ndarray

    def __len__(self) -> int:
        return len(self.positions_m)

    def thinned(self, spacing_m: float) -> Places:
        """Return places that are at least this far apart along the way, the first among them."""
        kept = [0]
        for index, place in enumerate(self.positions_m):
            if np.linalg.norm(place - self.positions_m[kept[-1]]) >= spacing_m:
                kept.append(index)
        return Places(self.positions_m[kept], self.rotations[kept])


def visible_samples(
    surface: Surface, samples: Samples, places: Places, view: LidarView, rng: np.random.Generator
) -> np.ndarray:
    """Return which samples (n,) of a surface a lidar could see from any of the places."""
    normals, least = samples.normals, math.cos(math.radians(view.incidence_max_deg))

    def may_be_seen(some: np.ndarray, directions: np.ndarray, place: int, apart_m: np.ndarray) -> np.ndarray:
        up = directions @ places.rotations[place][:, 2]
        low, high = (math.sin(math.radians(each)) for each in view.elevation_deg)
        incidence = np.abs((directions * normals[some]).sum(axis=1))
        return (apart_m <= view.range_max_m) & (low <= up) & (up <= high) & (incidence >= least)

    return _seen(surface, samples.points_m, places, rng, may_be_seen)


def in_sight(surface: Surface, points_m: np.ndarray, places: Places, rng: np.random.Generator) -> np.ndarray:
    """Return which points (n,) of (n, 3) no surface hides from all of the places."""
    return _seen(surface, points_m, places, rng, lambda some, *_: np.ones(len(some), dtype=bool))


def _seen(
    surface: Surface,
    points_m: np.ndarray,
    places: Places,
    rng: np.random.Generator,
    may_be_seen: Callable[[np.ndarray, np.ndarray, int, np.ndarray], np.ndarray],
) -> np.ndarray:
    """Try the places in an order drawn at random, each with the points that none has seen."""
    seen = np.zeros(len(points_m), dtype=bool)
    for place in rng.permutation(len(places)):
        some = np.flatnonzero(~seen)
        if not len(some):
            break
        towards = points_m[some] - places.positions_m[place]
        apart_m = np.linalg.norm(towards, axis=1)
        directions = towards / np.maximum(apart_m[:, None], 1e-9)
        tried = may_be_seen(some, directions, place, apart_m)
        some, directions, apart_m = some[tried], directions[tried], apart_m[tried]
        if len(some):
            origins = np.broadcast_to(places.positions_m[place], directions.shape)
            ranges_m = surface.ranges_m(origins, directions)
            seen[some[ranges_m >= apart_m - OFF_SURFACE_M]] = True
    return seen
