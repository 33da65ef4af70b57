"""The map error of a simulated run: distance of an occupancy grid from the true walls."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from gridslam import se2
from gridslam.errors import EvaluationError
from gridslam.evaluation.wall_fit import WallFit, wall_fits
from gridslam.evaluation.walls import WallPoints, Walls
from gridslam.occupancy_grid import OccupancyGrid


@dataclass(frozen=True)
class MapAccuracy:
    """A map's errors. Distances are those of occupied cells' centres from the nearest true wall.

    Even in a perfect map the centres lie up to half a cell's diagonal from their wall, a quarter cell on
    average.
    """

    occupied_cells: int
    mean_m: float
    p95_m: float
    max_m: float
    seen_share: float
    """Share of the true walls' length that has an occupied cell within `seen_within_m`, 0..1."""
    seen_within_m: float
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
        seen_within_m: a piece of true wall counts as seen if an occupied cell is this near.
        wall_length_min_m: walls shorter than this get no measure of straightness.
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
    fits: list[WallFit] = []
    if isinstance(walls, Walls):  # bare points do not form walls
        fits = wall_fits(walls, points, distance, nearest, wall_length_min_m, wall_gate_m)
    return MapAccuracy(
        occupied_cells=len(points),
        mean_m=float(distance.mean()),
        p95_m=float(np.percentile(distance, 95.0)),
        max_m=float(distance.max()),
        seen_share=float(lengths[seen].sum() / lengths.sum()),
        seen_within_m=seen_within_m,
        walls=tuple(fits),
    )
