"""A plan of nearer photographs: the second look at what the first one did not show well enough."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple, Protocol, Sequence

import numpy as np

from flight_basics.errors import SurveyError
from inspection.camera.survey_camera import SurveyCamera
from inspection.survey.plan import SurveyPlan
from inspection.survey.surface.room import Room
from inspection.survey.tour.flown import flown
from inspection.survey.views.candidates import OFF_SURFACE_M, Ranges, View

TRIED = 200
"""Directions from which a place is tried."""
FLATTEST_DEG = 45.0
ROOM_M, ROOM_RAYS = 1.2, 100
"""CEPA's outer cushion; rays by which the room around a place is measured."""
TRIES = 300


class Place(Protocol):
    """What is looked at: its place, and the surface's normal."""

    @property
    def position_m(self) -> tuple[float, ...]:
        """(x, y, z) in the map."""

    @property
    def normal(self) -> tuple[float, ...]:
        """Unit, to the air."""


class Closer(NamedTuple):
    """plan: of the nearer photographs. hidden: indices of the places that none can show."""

    plan: SurveyPlan
    hidden: tuple[int, ...]


def closer_plan(
    plan: SurveyPlan,
    places: Sequence[Place],
    room: Room,
    ranges_m: Ranges,
    resolution_mm: float,
    rng: np.random.Generator,
) -> Closer:
    """Return a plan that photographs each place once, in its middle at this resolution.

    plan: of the first look; tells camera, UAV and home.

    Raises:
        SurveyError: the UAV gets to none of the places.
    """
    views = [closer_view(each, room, ranges_m, plan.camera, resolution_mm) for each in places]
    hidden = tuple(k for k, view in enumerate(views) if view is None)
    shots = [view for view in views if view is not None]
    if not shots:
        raise SurveyError(
            f"None of {len(places)} places can be photographed at {resolution_mm:g} mm per pixel."
        )
    flights, figures = flown(room, shots, replace(plan.flying, passing=False), rng, TRIES)
    asked = replace(plan.asked, resolution=resolution_mm)
    nearer = replace(plan, asked=asked, flights=flights, figures=figures, shares={}, leftovers=())
    return Closer(nearer, hidden)


def closer_view(
    place: Place, room: Room, ranges_m: Ranges, camera: SurveyCamera, resolution_mm: float
) -> View | None:
    """Return the view of a place that looks at it most squarely, from where the UAV fits; None: none.

    Places with much room come first, for near other surfaces CEPA pushes the UAV about.
    """
    normal = np.array(place.normal)
    point_m = np.array(place.position_m) + OFF_SURFACE_M * normal
    directions = _around(normal)
    steep = directions @ normal
    eyes_m = point_m + 1e-3 * resolution_mm * camera.focal_px * steep[:, None] * directions
    fits = room.at(room.flyable, eyes_m)
    tilts = np.degrees(np.arcsin(np.clip(-directions[:, 2], -1.0, 1.0)))
    fits &= (tilts >= camera.tilt_min) & (tilts <= camera.tilt_max)
    far_m = np.linalg.norm(eyes_m - point_m, axis=1)
    fits &= ranges_m(np.tile(point_m, (len(eyes_m), 1)), directions) > far_m
    if not fits.any():
        return None
    candidates = np.flatnonzero(fits)
    rooms_m = np.array(
        [ranges_m(np.tile(eyes_m[k], (ROOM_RAYS, 1)), _sphere(ROOM_RAYS)).min() for k in candidates]
    )
    best = int(candidates[np.lexsort((-steep[candidates], rooms_m < ROOM_M))[0]])
    x, y, z = eyes_m[best].tolist()
    towards = -directions[best]
    return View((x, y, z), math.atan2(towards[1], towards[0]), math.asin(np.clip(towards[2], -1.0, 1.0)))


def _around(normal: np.ndarray) -> np.ndarray:
    """Return unit directions (n, 3) evenly over the cap about a normal; the first is the normal."""
    number = np.arange(TRIED)
    turns = math.pi * (1.0 + math.sqrt(5.0)) * number
    ahead = 1.0 - (1.0 - math.cos(math.radians(FLATTEST_DEG))) * number / TRIED
    level = np.sqrt(1.0 - ahead**2)
    aside = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    aside /= np.linalg.norm(aside)
    up = np.cross(normal, aside)
    return (
        ahead[:, None] * normal + np.outer(level * np.cos(turns), aside) + np.outer(level * np.sin(turns), up)
    )


def _sphere(count: int) -> np.ndarray:
    """Return unit directions (count, 3), evenly over the sphere."""
    number = np.arange(count) + 0.5
    heights, turns = 1.0 - 2.0 * number / count, math.pi * (1.0 + math.sqrt(5.0)) * number
    level = np.sqrt(1.0 - heights**2)
    return np.column_stack((level * np.cos(turns), level * np.sin(turns), heights))
