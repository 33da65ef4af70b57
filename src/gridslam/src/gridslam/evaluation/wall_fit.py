"""Straightness of a map's walls: fits a line to the occupied cells of each true wall."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from gridslam.evaluation.walls import Walls

FIT_CELLS_MIN = 8  # with fewer cells a fitted line means nothing
FIT_SHARE_MIN = 0.75  # the cells must cover at least this share of the shortest measured wall
NEIGHBOURS_WITHIN_M = 0.3


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


def wall_fits(
    walls: Walls,
    points: np.ndarray,
    distance: np.ndarray,
    nearest: np.ndarray,
    length_min_m: float,
    gate_m: float,
) -> list[WallFit]:
    """Fit a line to the cells of every straight wall, longest wall first.

    A cell belongs to the wall nearest to it, unless its neighbours lie across that wall. In a displaced map
    the ends of a wall may lie nearest to the walls that it meets.

    Args:
        walls: the true walls.
        points: (p, 2) occupied cells' centres, m, in the frame of the walls.
        distance: (p,) their distance to the nearest wall, m.
        nearest: (p,) that wall segment's index.
        length_min_m: shorter walls are left out.
        gate_m: cells farther from their wall than this do not count.
    """
    directions = _double_angles(points)
    fits = []
    for segments in walls.straight_walls():
        ends = walls.ends_m[segments]
        if walls.lengths_m[segments].sum() < length_min_m:
            continue
        along = ends[0, 2:] - ends[0, :2]
        angle = 2.0 * math.atan2(along[1], along[0])
        agrees = directions @ (math.cos(angle), math.sin(angle)) > 0.0
        own = points[np.isin(nearest, segments) & (distance <= gate_m) & agrees]
        if len(own) < FIT_CELLS_MIN:
            continue
        if np.ptp(own @ along) / np.hypot(*along) >= FIT_SHARE_MIN * length_min_m:
            fits.append(_fit(_extent(ends), own))
    return sorted(
        fits, key=lambda fit: -math.hypot(fit.ends_m[2] - fit.ends_m[0], fit.ends_m[3] - fit.ends_m[1])
    )


def _double_angles(points: np.ndarray) -> np.ndarray:
    """Return the sum of d^2 (cos 2a, sin 2a) over each cell's neighbours, (p, 2).

    With doubled angles opposite directions are equal, and directions at right angles are opposite.
    """
    pairs = cKDTree(points).query_pairs(NEIGHBOURS_WITHIN_M, output_type="ndarray")
    x, y = (points[pairs[:, 1]] - points[pairs[:, 0]]).T
    both = pairs.T.ravel()
    sums = [
        np.bincount(both, np.tile(part, 2), minlength=len(points)) for part in (x * x - y * y, 2.0 * x * y)
    ]
    return np.column_stack(sums)


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
