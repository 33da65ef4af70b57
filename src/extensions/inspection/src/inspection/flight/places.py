"""Places of the UAV for a view of its camera."""

from __future__ import annotations

import math

import numpy as np

from exploration.planning import PathPlanner
from exploration.planning.space import Space
from flight_basics.errors import NoPathError
from inspection.survey.views.candidates import View

TRIED, LEAST_STEEP = 200, 0.5
"""Directions from which a closer look is tried, and the least cosine of its incidence."""
OPEN = 0.95
"""A point with so much air around it lies on no surface."""


def body_place_m(view: View, offset_m: np.ndarray) -> np.ndarray:
    """Return (x, y, z) of the UAV whose camera, at this offset in its frame, is at the view's place."""
    cosine, sine = math.cos(view.yaw_rad), math.sin(view.yaw_rad)
    x, y, z = offset_m
    return np.array(view.place_m) - (cosine * x - sine * y, sine * x + cosine * y, z)


def place_nearby(space: Space, place_m: np.ndarray, reach_m: float) -> np.ndarray | None:
    """Return the nearest voxel's centre (x, y, z) with room for the UAV; None: there is none so near."""
    centre = space.inner(place_m)
    reach = reach_m / space.grid.resolution_m
    low = np.clip(np.floor(centre - reach).astype(int), 0, space.squares.shape)
    high = np.clip(np.ceil(centre + reach).astype(int) + 1, 0, space.squares.shape)
    part = space.squares[tuple(map(slice, low.tolist(), high.tolist()))]
    there = np.argwhere(part >= space.need) + low + 0.5
    if not len(there):
        return None
    far = ((there - centre) ** 2).sum(axis=1)
    best = int(far.argmin())
    return space.outer(there[best : best + 1])[0] if far[best] <= reach**2 else None


def view_of_point(
    planner: PathPlanner,
    point_m: np.ndarray,
    here_m: np.ndarray,
    distance_m: float,
    offset_m: np.ndarray,
    stamp_s: float = 0.0,
) -> View | None:
    """Return a view of a point (x, y, z) from a distance, where the UAV gets to from here.

    None: there is none. Places where the UAV has its comfort come first, and of them the one that sees the
    surface most squarely: near a wall, CEPA would push the UAV about.
    """
    space = planner.space(stamp_s, here_m)
    directions, squarely = _directions(), outward(space, point_m, distance_m)
    if not squarely.any():
        squarely = here_m - point_m
    steep = directions @ squarely / max(float(np.linalg.norm(squarely)), 1e-9)
    views = [_view(point_m, distance_m, each) for each in directions]
    bodies_m = np.array([body_place_m(view, offset_m) for view in views])
    comfort = (planner.parameters.clearance_m + planner.parameters.comfort) / space.grid.resolution_m
    squares = _squares_at(space, bodies_m)
    for k in np.lexsort((-steep, squares < (comfort - 1.0) ** 2)):
        if steep[k] < LEAST_STEEP or squares[k] < space.need:
            continue
        try:
            planner.plan(here_m, bodies_m[k], stamp_s)
        except NoPathError:
            continue
        return views[k]
    return None


def outward(space: Space, point_m: np.ndarray, reach_m: float) -> np.ndarray:
    """Return (3,) where the air around a point is, not of unit length: before a wall, its normal.

    0: on all sides.
    """
    centre = space.inner(point_m)
    reach = reach_m / space.grid.resolution_m
    low = np.clip(np.floor(centre - reach).astype(int), 0, space.squares.shape)
    high = np.clip(np.ceil(centre + reach).astype(int) + 1, 0, space.squares.shape)
    free = np.argwhere(space.squares[tuple(map(slice, low.tolist(), high.tolist()))] > 0) + low + 0.5 - centre
    free = free[(free**2).sum(axis=1) <= reach**2]
    whole = 4.0 / 3.0 * math.pi * reach**3
    if len(free) > OPEN * whole:
        return np.zeros(3)
    return free.sum(axis=0)[::-1] / whole


def _squares_at(space: Space, places_m: np.ndarray) -> np.ndarray:
    index = np.floor([space.inner(each) for each in places_m]).astype(int)
    inside = ((index >= 0) & (index < space.squares.shape)).all(axis=1)
    found = np.zeros(len(index))
    found[inside] = space.squares[tuple(index[inside].T)]
    return found


def _directions() -> np.ndarray:
    """Return (TRIED, 3) unit directions, evenly over the sphere."""
    number = np.arange(TRIED) + 0.5
    heights, turns = 1.0 - 2.0 * number / TRIED, math.pi * (1.0 + math.sqrt(5.0)) * number
    level = np.sqrt(1.0 - heights**2)
    return np.column_stack((level * np.cos(turns), level * np.sin(turns), heights))


def _view(point_m: np.ndarray, distance_m: float, direction: np.ndarray) -> View:
    x, y, z = (point_m + distance_m * direction).tolist()
    tilt = math.asin(np.clip(-direction[2], -1.0, 1.0))
    return View((x, y, z), math.atan2(-direction[1], -direction[0]), tilt)
