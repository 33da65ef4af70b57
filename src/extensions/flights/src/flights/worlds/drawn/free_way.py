"""Whether a way leads through a world: flood fill of a grid that keeps a distance from all shapes."""

from __future__ import annotations

from typing import Sequence

import numpy as np
from scipy import ndimage

from flights.worlds.floor_plan import Outline, outlines
from flights.worlds.writer import Prop, write_model
from simulation_tools.sdf.elements import World
from simulation_tools.sdf.parser import parse_model

CELL_M = 0.1
KEEP_M = 0.5
"""A way through a drawn world leaves this much to both sides of the UAV's middle."""


def shapes_of(props: Sequence[Prop]) -> list[Outline]:
    """Return the outlines of all solid parts."""
    models = tuple(parse_model(write_model(prop), prop.name) for prop in props)
    return outlines(World("drawn", models=models))


def way_exists(
    shapes: Sequence[Outline],
    goal_x_m: float,
    half_width_m: float,
    heights_m: Sequence[float],
    keep_m: float = KEEP_M,
    beyond_m: float = 0.0,
) -> bool:
    """Tell whether a point can move from the origin to the goal on the x axis, keep_m away from all shapes.

    It stays within half_width_m of the x axis, and goes no more than beyond_m behind the start or past the
    goal. It stays at these heights, which are evenly spaced, and starts and ends at the middle one.
    """
    x = np.arange(-beyond_m, goal_x_m + beyond_m + CELL_M / 2, CELL_M)
    y = CELL_M * np.arange(-round(half_width_m / CELL_M), round(half_width_m / CELL_M) + 1)
    z = np.asarray(heights_m, dtype=float)
    free = np.ones((len(x), len(y), len(z)), dtype=bool)
    for shape in shapes:
        low, high = shape.outline_xy.min(axis=0) - keep_m, shape.outline_xy.max(axis=0) + keep_m
        rows, columns = (slice(*np.searchsorted(a, (low[i], high[i]))) for i, a in enumerate((x, y)))
        points = np.stack(np.meshgrid(x[rows], y[columns], indexing="ij"), axis=-1)
        aside_m = distance_m(points, shape.outline_xy)[..., None]
        above_m = np.maximum(np.maximum(shape.bottom_m - z, z - shape.top_m), 0.0)
        free[rows, columns] &= np.hypot(aside_m, above_m) >= keep_m
    areas, _ = ndimage.label(free)
    start, goal = (areas[np.abs(x - at).argmin(), len(y) // 2, len(z) // 2] for at in (0.0, goal_x_m))
    return bool(start == goal != 0)


def distance_m(points_xy: np.ndarray, corners_xy: np.ndarray) -> np.ndarray:
    """Return the distances of points (..., 2) from a convex polygon (n, 2, counter-clockwise); 0 inside."""
    x, y = (points_xy[..., None, axis] - corners_xy[:, axis] for axis in (0, 1))
    along_x, along_y = (np.roll(corners_xy, -1, axis=0) - corners_xy).T
    share = np.clip((x * along_x + y * along_y) / (along_x**2 + along_y**2), 0.0, 1.0)
    outside = along_x * y - along_y * x < 0.0
    squares = (x - share * along_x) ** 2 + (y - share * along_y) ** 2
    return np.where(outside.any(-1), np.sqrt(squares.min(-1)), 0.0)
