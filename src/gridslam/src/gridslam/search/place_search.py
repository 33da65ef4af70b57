"""Finds every place of a map where a set of points fits: branch and bound.

W. Hess, D. Kohler, H. Rapp and D. Andor, "Real-time loop closure in 2D LIDAR SLAM" (ICRA 2016).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from gridslam import se2
from gridslam.kernels.least_squares import inverse
from gridslam.kernels.places import best_places, mean_squares
from gridslam.maps.mapped_arrays import mapped_zeros
from gridslam.search.field import FULL, UNSEEN, LikelihoodField

SPLITS = 3
"""The largest blocks of positions are 4 to the power of this many cells wide."""
POINTS_MAX = 250
"""More points than this cost time and tell nothing new."""
INDEPENDENT_POINTS = 20.0
"""Points count as at most this many independent ones, because their errors are similar."""
CURVATURE_MIN = 1e-2
"""Less curvature of the mean squared distance than this (m2 per m2 or rad2) tells nothing."""
REFINEMENT_STEPS = (1.0, 0.5, 0.5)
"""Cells: distances of the poses that a refinement compares."""
NEIGHBOURS = np.array(list(product((-1.0, 0.0, 1.0), repeat=3)))


def _paraboloid(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return the (10, 27) least squares fit of 1, x, y, z, and their products to values at 27 points."""
    ones = np.ones_like(x)
    return np.linalg.pinv(np.stack([ones, x, y, z, x * x, y * y, z * z, x * y, x * z, y * z], axis=1))


PARABOLOID = _paraboloid(*NEIGHBOURS.T)


@dataclass(frozen=True)
class SearchSettings:
    """What counts as a place.

    Attributes:
        score_min: least mean fit of the points, 0 to 1.
        rival_share: rivals that reach less than this share of the best score are not reported.
        places_max: search ends after this many places.
        apart_m, apart_rad: a place differs from another by at least this distance, or by at least this
            heading.
        point_sigma_m: standard deviation of a point from its surface, for the covariance.
    """

    score_min: float = 0.6
    rival_share: float = 0.85
    places_max: int = 4
    apart_m: float = 0.6
    apart_rad: float = 0.35
    point_sigma_m: float = 0.03


@dataclass(frozen=True)
class Window:
    """Limits of a search: poses at most this far from a centre (x m, y m, yaw rad), along each axis."""

    centre: np.ndarray
    reach_m: float
    reach_rad: float


@dataclass(frozen=True, eq=False)
class Place:
    """A pose at which points fit.

    Attributes:
        pose: (3,) x m, y m, yaw rad of the points' frame in the map's.
        score: mean fit of the points, 0 to 1.
        covariance: (3, 3) of the pose, in the map's axes (m, m, rad): large where the points say nothing.
    """

    pose: np.ndarray
    score: float
    covariance: np.ndarray


class PlaceSearch:
    """Searches one map for points.

    It judges every position in the map, in steps of a cell, and every heading. A block of positions has an
    upper bound of its scores: that of the greatest fits in a block of cells. The block with the highest
    bound is split first, so the first single position that comes up is the best one. No prior pose is
    needed, and the same input gives the same places.
    """

    def __init__(self, field: LikelihoodField) -> None:
        self._levels = _levels(field.table, SPLITS)
        margin = 4**SPLITS
        self._field = replace(field, table=self._levels[0, margin:, margin:])  # once in memory

    def find(
        self, points_xy_m: np.ndarray, settings: SearchSettings, window: Window | None = None
    ) -> list[Place]:
        """Return the places where points (n, 2) fit, best first; later ones are rivals of the first.

        Args:
            points_xy_m: ends of beams in the frame whose pose is sought, for example the base.
            settings: what counts as a place.
            window: limits of the search; None: the whole map, any heading.
        """
        points = thinned(points_xy_m, 2.0 * self._field.resolution_m, POINTS_MAX)
        if not len(points):
            return []
        cell, origin = self._field.resolution_m, self._field.origin_xy_m
        angles = _angles(points, 2.0 * cell, window)
        cos, sin = np.cos(angles)[:, None], np.sin(angles)[:, None]
        x, y = points.T / cell
        cells = np.stack([cos * x - sin * y, sin * x + cos * y], axis=2)
        height, width = self._field.table.shape
        box = np.array([0, 0, width - 1, height - 1])
        if window is not None:
            middle = (np.asarray(window.centre)[:2] - origin) / cell
            half = math.ceil(window.reach_m / cell)
            box = np.concatenate([np.floor(middle) - half, np.floor(middle) + half]).astype(np.int64)
        apart = np.array([settings.apart_m / cell, settings.apart_rad])
        found, scores = best_places(
            self._levels,
            UNSEEN,
            np.floor(cells + 0.5).astype(np.int32),
            angles,
            box,
            apart,
            settings.score_min * FULL * len(points),
            settings.rival_share,
            settings.places_max,
        )
        places = []
        for (angle, column, row), score in zip(found, scores):
            pose = np.array(
                [*(origin + cell * (np.array([column, row]) + 0.5)), se2.wrap(angles[int(angle)])]
            )
            places.append(self._refined(pose, points, score / (FULL * len(points)), settings))
        return places

    def _refined(self, pose: np.ndarray, points: np.ndarray, score: float, settings: SearchSettings) -> Place:
        """Fit paraboloids to the mean squared distance around a pose, for its minimum and its curvature."""
        for share in REFINEMENT_STEPS:
            pose, curvature = self._lowest(pose, points, share * self._field.resolution_m)
        independent = min(len(points), INDEPENDENT_POINTS)
        covariance = 2.0 * settings.point_sigma_m**2 / independent * inverse(curvature)
        return Place(np.array([*pose[:2], se2.wrap(pose[2])]), float(score), covariance)

    def _lowest(self, pose: np.ndarray, points: np.ndarray, step_m: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the minimum, at most a step away, and the curvature (3, 3) there."""
        cell = self._field.resolution_m
        radius = max(1.0, float(np.sqrt((points**2).sum(axis=1).mean())))
        steps = np.array([step_m, step_m, step_m / radius])
        squares = mean_squares(
            self._field.table,
            self._field.blur_m**2,
            (pose + NEIGHBOURS * steps - (*self._field.origin_xy_m, 0.0)) / (cell, cell, 1.0),
            points / cell,
        )
        _, *slope, xx, yy, zz, xy, xz, yz = PARABOLOID @ squares
        curvature = np.array([[2 * xx, xy, xz], [xy, 2 * yy, yz], [xz, yz, 2 * zz]]) / np.outer(steps, steps)
        values, vectors = np.linalg.eigh(curvature)
        curvature = (vectors * np.maximum(values, CURVATURE_MIN)) @ vectors.T
        return pose + np.clip(np.linalg.solve(curvature, -np.array(slope) / steps), -steps, steps), curvature


def thinned(points_xy_m: np.ndarray, spacing_m: float, most: int) -> np.ndarray:
    """Return the mean of the points in each square of `spacing_m`, at most this many at even steps."""
    if not len(points_xy_m):
        return np.zeros((0, 2))
    _, group, count = np.unique(
        np.floor(points_xy_m / spacing_m).astype(np.int64), axis=0, return_inverse=True, return_counts=True
    )
    sums = [np.bincount(group.reshape(-1), values) for values in points_xy_m.T]
    means = np.stack(sums, axis=1) / count[:, None]
    if len(means) <= most:
        return means
    return means[np.linspace(0, len(means) - 1, most).astype(int)]


def _levels(table: np.ndarray, splits: int) -> np.ndarray:
    """Return (splits + 1, h + m, w + m) uint8, m = 4^splits.

    Level k holds the greatest value of the 4^k x 4^k cells from each cell on. Its cell [m, m] is the table's
    first. Around the table the value is UNSEEN. Levels of 2^k cells would need nearly twice the memory.
    """
    margin = 4**splits
    levels = mapped_zeros((splits + 1, table.shape[0] + margin, table.shape[1] + margin), np.uint8)
    levels[0] = UNSEEN
    levels[0, margin:, margin:] = table
    for level in range(splits):
        _spread(levels[level], 4**level, levels[level + 1])
        _spread(levels[level + 1], 2 * 4**level, levels[level + 1])
    return levels


def _spread(values: np.ndarray, by: int, out: np.ndarray) -> None:
    """Write the greatest of each value and of those this many rows, columns, or both, after it."""
    np.maximum(values[:-by], values[by:], out=out[:-by])
    np.maximum(values[-by:], UNSEEN, out=out[-by:])
    np.maximum(out[:, :-by], out[:, by:], out=out[:, :-by])
    np.maximum(out[:, -by:], UNSEEN, out=out[:, -by:])


def _angles(points: np.ndarray, step_m: float, window: Window | None) -> np.ndarray:
    """Headings so close that most points move by at most `step_m` from one to the next."""
    radius = max(1.0, float(np.percentile(np.hypot(*points.T), 80.0)))
    if window is None:
        return np.linspace(-math.pi, math.pi, math.ceil(2.0 * math.pi * radius / step_m), endpoint=False)
    count = math.ceil(window.reach_rad * radius / step_m)
    return float(window.centre[2]) + np.linspace(-window.reach_rad, window.reach_rad, 2 * count + 1)
