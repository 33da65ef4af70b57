"""What cannot be photographed, and why."""

from __future__ import annotations

import numpy as np

from inspection.survey.parameters import SurveyParameters
from inspection.survey.plan import Leftover
from inspection.survey.surface.room import Room
from inspection.survey.views.candidates import OFF_SURFACE_M, Candidates, Ranges

NO_ROOM = "no room for the UAV where it could be seen from"
INCIDENCE = "seen at too flat an angle only"
TOO_FAR = "seen from too far only"
HIDDEN = "hidden behind other parts"
PLACES = 1500
"""Places from which the line of sight is tried; of more, so many are drawn evenly."""
CELL_M = 5.0
"""Leftovers of one thing and one reason within a cube of this side count together."""


def leftovers_of(
    room: Room, candidates: Candidates, asked: SurveyParameters, ranges_m: Ranges
) -> tuple[Leftover, ...]:
    """Return what is not reachable, the largest first."""
    patches = candidates.patches
    left = np.flatnonzero(~candidates.reachable)
    if not len(left):
        return ()
    places_m = candidates.places_m[:: max(1, len(candidates.places_m) // PLACES)]
    seen, steep = _sight(left, patches.points_m, patches.normals, places_m, ranges_m, asked.incidence)
    front_m = patches.points_m[left] + 0.6 * candidates.lens[2] * patches.normals[left]
    way = front_m - patches.points_m[left]
    apart = np.linalg.norm(way, axis=1)
    begins = patches.points_m[left] + 0.005 * patches.normals[left]
    is_open = ranges_m(begins, way / apart[:, None]) > min(asked.clearance_m, 0.3)
    why = np.where(steep, TOO_FAR, np.where(seen, INCIDENCE, np.where(is_open, NO_ROOM, HIDDEN)))
    cells = np.floor(patches.points_m[left] / CELL_M).astype(np.int64)
    groups: dict[tuple, list[int]] = {}
    for k, (part, reason, cell) in enumerate(zip(patches.parts[left], why, cells.tolist())):
        groups.setdefault((int(part), str(reason), *cell), []).append(k)
    found = []
    for (part, reason, *_), members in groups.items():
        own = left[members]
        middle = np.average(patches.points_m[own], axis=0, weights=patches.areas_m2[own])
        x, y, z = middle.tolist()
        found.append(Leftover(patches.names[part], reason, float(patches.areas_m2[own].sum()), (x, y, z)))
    return tuple(sorted(found, key=lambda each: -each.area_m2))


def _sight(
    left: np.ndarray,
    points_m: np.ndarray,
    normals: np.ndarray,
    places_m: np.ndarray,
    ranges_m: Ranges,
    incidence_deg: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return which of the patches left any place sees, and which at an angle that is steep enough."""
    seen, steep = np.zeros(len(left), bool), np.zeros(len(left), bool)
    least = np.cos(np.radians(incidence_deg))
    for place_m in places_m:
        some = np.flatnonzero(~steep)
        way = points_m[left[some]] - place_m
        apart = np.linalg.norm(way, axis=1)
        cosine = -(way * normals[left[some]]).sum(axis=1) / apart
        candidates = (cosine > 0.02) & ~(seen[some] & (cosine < least))
        some, way, apart, cosine = some[candidates], way[candidates], apart[candidates], cosine[candidates]
        if not len(some):
            continue
        origins = np.broadcast_to(place_m, way.shape)
        is_open = ranges_m(origins, way / apart[:, None]) >= apart - OFF_SURFACE_M
        seen[some[is_open]] = True
        steep[some[is_open & (cosine >= least)]] = True
    return seen, steep
