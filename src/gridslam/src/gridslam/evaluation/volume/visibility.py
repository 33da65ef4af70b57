"""What a lidar could see from where it was, by rays."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable

import numpy as np

from flight_basics.checks import check_limits, limited
from gridslam.errors import EvaluationError
from gridslam.evaluation.volume.surface import Samples, Surface

OFF_SURFACE_M = 0.01
"""A ray that ends this near to a point has reached it."""
BEAMS = 20_000
"""Directions that are tried from each place for the box of what is reached."""
EDGE_M = 1.0
"""More on each side of this box."""


@dataclass(frozen=True)
class LidarView:
    """What a lidar's beams reach. A lidar that nods or leans sees through its places' attitudes.

    Raises:
        EvaluationError: a bound makes no sense.
    """

    elevation_deg: tuple[float, float] = (-90.0, 90.0)
    """Lowest and highest beam, from the lidar's plane."""
    field_of_view_deg: float = limited(360.0, above=0.0, most=360.0)
    """In the lidar's plane, as much to the left as to the right."""
    range_max_m: float = limited(30.0, above=0.0)
    incidence_max_deg: float = limited(80.0, above=0.0, most=90.0)
    """A surface that beams graze at a greater angle from its normal counts as one that could not be seen."""

    def __post_init__(self) -> None:
        low, high = self.elevation_deg
        if not -90.0 <= low < high <= 90.0:
            raise EvaluationError(f"Elevations of {low:g} to {high:g} deg: use -90 <= LOW < HIGH <= 90.")
        check_limits(self, EvaluationError, "The lidar's {}")


@dataclass(frozen=True)
class Places:
    """Where the lidar was: positions_m (n, 3) and rotations (n, 3, 3), lidar to world."""

    positions_m: np.ndarray
    rotations: np.ndarray

    def __len__(self) -> int:
        return len(self.positions_m)

    def thinned(self, spacing_m: float, turn_deg: float = 180.0) -> Places:
        """Return places along the way, the first among them, each as far or as turned from the one before."""
        kept, cosine = [0], math.cos(math.radians(turn_deg))
        for index, place in enumerate(self.positions_m):
            apart_m = np.linalg.norm(place - self.positions_m[kept[-1]])
            turned = 0.5 * (np.sum(self.rotations[index] * self.rotations[kept[-1]]) - 1.0)
            if apart_m >= spacing_m or turned < cosine - 1e-9:
                kept.append(index)
        return Places(self.positions_m[kept], self.rotations[kept])

    def moved(self, offset_m: np.ndarray) -> Places:
        """Return the places of a lidar that is mounted at an offset (3,), m, from these."""
        return Places(self.positions_m + self.rotations @ offset_m, self.rotations)


def visible_samples(
    surface: Surface, samples: Samples, places: Places, view: LidarView, rng: np.random.Generator
) -> np.ndarray:
    """Return which samples (n,) of a surface a lidar could see from any of the places."""
    normals, least = samples.normals, math.cos(math.radians(view.incidence_max_deg))

    def may_be_seen(some: np.ndarray, directions: np.ndarray, place: int, apart_m: np.ndarray) -> np.ndarray:
        incidence = np.abs((directions * normals[some]).sum(axis=1))
        is_met = _has_beam(view, directions, places.rotations[place])
        return (apart_m <= view.range_max_m) & (incidence >= least) & is_met

    return _seen(surface, samples.points_m, places, rng, may_be_seen)


def reached_box(
    surface: Surface, places: Places, view: LidarView, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of a box around the surfaces that beams drawn at random reach from the places.

    Raises:
        EvaluationError: they reach none.
    """
    least, ends = math.cos(math.radians(view.incidence_max_deg)), []
    for position_m, rotation in zip(places.positions_m, places.rotations):
        directions = rng.normal(size=(BEAMS, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        directions = directions[_has_beam(view, directions, rotation)]
        ranges_m, normals = surface.hits(np.broadcast_to(position_m, directions.shape), directions)
        met = (ranges_m <= view.range_max_m) & (np.abs((directions * normals).sum(axis=1)) >= least)
        ends.append(position_m + directions[met] * ranges_m[met, None])
    reached_m = np.concatenate(ends)
    if not len(reached_m):
        raise EvaluationError(
            "The lidar reaches no surface from any place of the path. Are path and world in the same frame?"
        )
    return reached_m.min(axis=0) - EDGE_M, reached_m.max(axis=0) + EDGE_M


def _has_beam(view: LidarView, directions: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Return which directions (n, 3) in the world lie within the beams of a lidar of a rotation (3, 3)."""
    forward, left, up = (directions @ rotation).T
    low, high = (math.sin(math.radians(each)) for each in view.elevation_deg)
    half = math.radians(view.field_of_view_deg) / 2.0
    return (low <= up) & (up <= high) & (np.abs(np.arctan2(left, forward)) <= half + 1e-9)


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
