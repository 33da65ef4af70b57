"""Places of the UAV for a view of its camera."""

from __future__ import annotations

import math

import numpy as np

from inspection_tools.errors import NoPathError
from inspection_tools.planning import PathPlanner
from inspection_tools.planning.space import Space
from inspection_tools.survey.views.candidates import View

TRIED = 48
"""Directions from which a closer look is tried."""


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
    planner: PathPlanner, point_m: np.ndarray, here_m: np.ndarray, distance_m: float, offset_m: np.ndarray
) -> View | None:
    """Return a view of a point (x, y, z) from a distance, where the UAV gets to from here.

    None: there is none. The direction nearest to that of the UAV is taken.
    """
    number = np.arange(TRIED) + 0.5
    heights, turns = 1.0 - 2.0 * number / TRIED, math.pi * (1.0 + math.sqrt(5.0)) * number
    level = np.sqrt(1.0 - heights**2)
    directions = np.column_stack((level * np.cos(turns), level * np.sin(turns), heights))
    towards = here_m - point_m
    towards = towards / max(float(np.linalg.norm(towards)), 1e-6)
    for direction in np.concatenate((towards[None], directions[np.argsort(-(directions @ towards))])):
        place_m = point_m + distance_m * direction
        yaw, tilt = math.atan2(-direction[1], -direction[0]), math.asin(np.clip(-direction[2], -1.0, 1.0))
        view = View((float(place_m[0]), float(place_m[1]), float(place_m[2])), yaw, tilt)
        try:
            planner.plan(here_m, body_place_m(view, offset_m))
        except NoPathError:
            continue
        return view
    return None
