"""How far an occupancy grid is from the true world: the map error of a simulated run."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from gridslam import se2
from gridslam.errors import EvaluationError
from gridslam.evaluation.walls import WallPoints, Walls
from gridslam.occupancy_grid import OccupancyGrid

FIT_CELLS_MIN = 8  # a line through fewer cells says nothing about a wall


@dataclass(frozen=True)
class WallFit:
    """One straight wall of the world, and the line through the occupied cells near it."""

    ends_m: tuple[float, float, float, float]
    """The true wall's first and last point: x1, y1, x2, y2."""
    cells: int
    """Occupied cells that belong to it."""
    straightness_rms_m: float
    """Root mean square deviation of those cells from the line fitted to them."""
    straightness_max_m: float
    """Greatest deviation from it."""
    turned_rad: float
    """Angle between fitted line and true wall, in (-pi/2, pi/2]."""
    offset_m: float
    """Distance of the true wall's line from the middle of its cells."""


@dataclass(frozen=True)
class MapAccuracy:
    """A map's errors. Distances are those of occupied cells' centres from the nearest true wall.

    Even a perfect map's cells have centres up to half a cell's diagonal from their wall, a quarter cell on
    average.
    """

    occupied_cells: int
    mean_m: float
    p95_m: float
    max_m: float
    seen_share: float
    """Share of the true walls' length that has an occupied cell within the tolerance, 0..1."""
    walls: tuple[WallFit, ...]
    """Straight walls of at least the asked length, longest first."""

    @property
    def straightness_rms_m(self) -> float:
        """Deviation of cells from their own wall's fitted line, over all straight walls; NaN: none."""
        cells = sum(wall.cells for wall in self.walls)
        squares = sum(wall.cells * wall.straightness_rms_m**2 for wall in self.walls)
        return math.sqrt(squares / cells) if cells else math.nan

    def as_dict(self) -> dict:
        """Return the figures under the names that result files use."""
        return {
            "map_error_mean_m": self.mean_m,
            "map_error_p95_m": self.p95_m,
            "map_error_max_m": self.max_m,
            "wall_seen_share": self.seen_share,
            "wall_straightness_rms_m": self.straightness_rms_m,
            "wall_turned_max_rad": max((abs(wall.turned_rad) for wall in self.walls), default=math.nan),
            "occupied_cells": self.occupied_cells,
        }


def map_error(
    grid: OccupancyGrid,
    walls: Walls | WallPoints,
    map_in_world: tuple[float, float, float] = (0.0, 0.0, 0.0),
    seen_within_m: float = 0.15,
    wall_length_min_m: float = 1.0,
    wall_gate_m: float = 0.5,
) -> MapAccuracy:
    """Compare a map with the true walls.

    Args:
        grid: the map.
        walls: the true walls, in the world's frame.
        map_in_world: pose (x m, y m, yaw rad) of the map's frame in the world.
        seen_within_m: a piece of true wall is seen when an occupied cell is this near.
        wall_length_min_m: walls shorter than this are not judged for straightness.
        wall_gate_m: cells farther from their wall than this do not count for its straightness.

    Raises:
        EvaluationError: the map has no occupied cell.
    """
    points = se2.transform(map_in_world, grid.occupied_xy())
    if not len(points):
        raise EvaluationError("The map has no occupied cell, so there is nothing to compare with the walls.")
    distance, nearest = walls.distances(points)
    samples, lengths = walls.samples(grid.resolution_m)
    seen = cKDTree(points).query(samples, distance_upper_bound=seen_within_m)[0] <= seen_within_m
    return MapAccuracy(
        occupied_cells=len(points),
        mean_m=float(distance.mean()),
        p95_m=float(np.percentile(distance, 95.0)),
        max_m=float(distance.max()),
        seen_share=float(lengths[seen].sum() / lengths.sum()),
        walls=tuple(_wall_fits(walls, points, distance, nearest, wall_length_min_m, wall_gate_m)),
    )


def _wall_fits(walls, points, distance, nearest, length_min_m, gate_m) -> list[WallFit]:
    fits = []
    for segments in walls.straight_walls():
        ends = walls.ends_m[segments]
        if walls.lengths_m[segments].sum() < length_min_m:
            continue
        own = points[np.isin(nearest, segments) & (distance <= gate_m)]
        if len(own) >= FIT_CELLS_MIN:
            fits.append(_fit(_extent(ends), own))
    return sorted(
        fits, key=lambda fit: -math.hypot(fit.ends_m[2] - fit.ends_m[0], fit.ends_m[3] - fit.ends_m[1])
    )


def _extent(ends: np.ndarray) -> np.ndarray:
    """Return the two points farthest apart along a wall's line, x1, y1, x2, y2."""
    corners = ends.reshape(-1, 2)
    along = corners @ (ends[0, 2:] - ends[0, :2])
    return np.concatenate([corners[along.argmin()], corners[along.argmax()]])


def _fit(ends: np.ndarray, points: np.ndarray) -> WallFit:
    """Fit a line by total least squares: the principal axis of the cells."""
    middle = points.mean(axis=0)
    _, axes = np.linalg.eigh(np.cov((points - middle).T))
    along, normal = axes[:, 1], axes[:, 0]
    deviation = (points - middle) @ normal
    direction = ends[2:] - ends[:2]
    turned = math.remainder(math.atan2(along[1], along[0]) - math.atan2(direction[1], direction[0]), math.pi)
    true_normal = np.array([-direction[1], direction[0]]) / np.hypot(*direction)
    return WallFit(
        ends_m=tuple(ends.tolist()),
        cells=len(points),
        straightness_rms_m=float(np.sqrt((deviation**2).mean())),
        straightness_max_m=float(np.abs(deviation).max()),
        turned_rad=turned,
        offset_m=float(abs((middle - ends[:2]) @ true_normal)),
    )
