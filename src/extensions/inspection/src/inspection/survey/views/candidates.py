"""Places from which the UAV could photograph, and what each of them sees."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from typing import Callable

import numpy as np
from scipy import ndimage

from flight_basics.errors import SurveyError
from inspection.camera.survey_camera import SurveyCamera
from inspection.survey.kernels.gains import best_views, bins_of, drawn_from, frames, likely_gains
from inspection.survey.kernels.sight import axes_of, drawn_straight, pairs_near
from inspection.survey.parameters import SurveyParameters
from inspection.survey.surface.patches import Patches
from inspection.survey.surface.room import Room

OFF_SURFACE_M = 0.01
CHUNK = 1_000_000
COST_PER_M, COST_MOST = 4.0, 3.0
"""Time of a photograph by how much the UAV lacks of its comfort, as a multiple. In hold_3d an Iris that CEPA
leads took 3.6 s where it had 1.4 m, 5.5 s at 1.35 m, 8.5 s at 1.1 m, 11 s below 1 m (324 photographs)."""
Ranges = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Distances (n,) to the first surface from origins (n, 3) along directions (n, 3)."""


def lens_of(camera: SurveyCamera, parameters: SurveyParameters, speed_m_s: float = 0.0) -> np.ndarray:
    """Return (4,) for the kernels: tangents to the edges, narrower by the pointing error; scale and blur.

    The scale is that of the resolution that is planned for.

    speed_m_s: at which the camera moves while it shoots.

    Raises:
        SurveyError: the motion alone blurs more than what is asked.
    """
    blur_mm = 1e3 * speed_m_s * camera.exposure
    if blur_mm >= parameters.resolution:
        raise SurveyError(
            f"At {speed_m_s:g} m/s an exposure of {camera.exposure:g} s blurs by {blur_mm:.2g} mm, but "
            f"{parameters.resolution:g} mm per pixel are asked: pass more slowly, or expose "
            "shorter."
        )
    planned_mm = parameters.resolution * (1.0 - parameters.finer)
    across, down = camera.half_extents
    off = math.radians(parameters.pointing_error)
    narrow = [math.tan(max(math.atan(each) - off, 1e-3)) for each in (across, down)]
    return np.array((*narrow, 1e-3 * planned_mm * camera.focal_px, 1e-3 * blur_mm * camera.focal_px))


def lattice(room: Room, spacing_m: float) -> np.ndarray:
    """Return the places (n, 3), m, of a lattice of voxels where the UAV may be."""
    step = max(1, round(spacing_m / room.voxel_m))
    first = np.array(
        [int(np.flatnonzero(room.flyable.any(axis=tuple({0, 1, 2} - {k})))[0]) for k in range(3)]
    )
    part = room.flyable[first[0] :: step, first[1] :: step, first[2] :: step]
    return room.outer(np.argwhere(part) * step + first + 0.5)


def near_home(room: Room, places_m: np.ndarray, most: int) -> np.ndarray:
    """Return those of places (n, 3), at most so many, that are nearest to home.

    Each has a way home that goes no farther from home than the farthest of them: none is behind a wall.
    """
    away_m = np.linalg.norm(places_m - room.home_m, axis=1)
    nearest = np.argsort(away_m, kind="stable")[:most]
    reach = float(away_m[nearest].max(initial=0.0)) / room.voxel_m + 1.0
    home = np.floor(room.inner(room.home_m)).astype(np.int64)
    low = np.maximum(np.floor(home - reach).astype(np.int64), 0)
    high = np.minimum(np.ceil(home + reach).astype(np.int64) + 1, room.flyable.shape)
    z, y, x = np.ogrid[tuple(map(slice, (low - home).tolist(), (high - home).tolist()))]
    ball = z * z + y * y + x * x <= reach * reach
    parts, _ = ndimage.label(room.flyable[tuple(map(slice, low.tolist(), high.tolist()))] & ball)
    voxels = np.floor(room.inner(places_m[nearest])).astype(np.int64) - low
    inside = ((voxels >= 0) & (voxels < parts.shape)).all(axis=1)
    here = np.zeros(len(nearest), np.int64)
    here[inside] = parts[tuple(voxels[inside].T)]
    return places_m[nearest[(here > 0) & (here == parts[tuple(home - low)])]]


@dataclass(frozen=True)
class View:
    """One photograph: place_m (3,) of the camera in the map's frame; yaw_rad; tilt_rad, up is positive."""

    place_m: tuple[float, float, float]
    yaw_rad: float
    tilt_rad: float


class Candidates:
    """Places and the patches in sight of each, near and steep enough for a photograph of some direction.

    Attributes:
        costs: (n,) of a photograph at each place, in times of one where the UAV has room.

    Args:
        patches: the surface. places_m: (n, 3). camera, parameters: what is asked.
        ranges_m: rays through what hides. speed_m_s: of the camera while it shoots.
    """

    def __init__(
        self,
        patches: Patches,
        places_m: np.ndarray,
        camera: SurveyCamera,
        parameters: SurveyParameters,
        ranges_m: Ranges,
        speed_m_s: float = 0.0,
    ):
        self.costs = np.ones(len(places_m))
        self.patches, self.places_m, self._asked = patches, places_m, parameters
        self.lens = lens_of(camera, parameters, speed_m_s)
        self._tilts = np.radians((camera.tilt_min, camera.tilt_max))
        self._frames = frames(self.lens, self._tilts)
        corner = math.cos(math.atan(math.hypot(self.lens[0], self.lens[1])))
        scale = self.lens[2] / corner**2
        least = math.cos(math.radians(parameters.incidence))
        begins, near = pairs_near(places_m, patches.points_m, patches.normals, scale, least, scale)
        is_seen = self._in_sight(begins, near, ranges_m)
        counts = np.add.reduceat(np.append(is_seen, False).astype(np.int64), begins[:-1]) if len(near) else 0
        counts = np.where(np.diff(begins) > 0, counts, 0)
        self.begins = np.concatenate(([0], np.cumsum(counts))).astype(np.int64)
        self.seen = near[is_seen].astype(np.int64)
        self.bins = bins_of(places_m, self.begins, self.seen, patches.points_m)
        self.reachable = self._reachable()

    def _in_sight(self, begins: np.ndarray, near: np.ndarray, ranges_m: Ranges) -> np.ndarray:
        is_seen = np.zeros(len(near), bool)
        of = np.repeat(np.arange(len(self.places_m)), np.diff(begins))
        for start in range(0, len(near), CHUNK):
            part = slice(start, start + CHUNK)
            origins = self.places_m[of[part]]
            way = self.patches.points_m[near[part]] - origins
            apart = np.linalg.norm(way, axis=1)
            is_seen[part] = ranges_m(origins, way / apart[:, None]) >= apart - OFF_SURFACE_M
        return is_seen

    @property
    def _of(self) -> np.ndarray:
        """The place (n,) of each pair of place and patch."""
        return np.repeat(np.arange(len(self.places_m)), np.diff(self.begins))

    def _are_drawn(self) -> np.ndarray:
        """Return for which pairs (n,) a photograph draws the patch if it looks straight at it."""
        p = self.patches
        return drawn_straight(self.places_m, self.begins, self.seen, p.points_m, p.normals, self.lens)

    def _reachable(self) -> np.ndarray:
        """Return which patches (n,) some photograph draws that looks straight at them."""
        found = np.zeros(len(self.patches), bool)
        found[self.seen[self._are_drawn()]] = True
        return found

    def preferring(self, preferred: np.ndarray) -> tuple[Candidates, np.ndarray]:
        """Return the preferred places (n,) and those that show what no other does; and which they are.

        All that was reachable still is.
        """
        of, drawn = self._of, self._are_drawn()
        by_preferred = np.zeros(len(self.patches), bool)
        by_preferred[self.seen[drawn & preferred[of]]] = True
        kept = preferred.copy()
        kept[of[drawn & ~by_preferred[self.seen]]] = True
        fewer, pairs = copy.copy(self), kept[of]
        fewer.places_m, fewer.seen, fewer.bins = self.places_m[kept], self.seen[pairs], self.bins[pairs]
        fewer.begins = np.concatenate(([0], np.cumsum(np.diff(self.begins)[kept]))).astype(np.int64)
        fewer.costs = self.costs[kept]
        return fewer, kept

    def comfortable(self, room: Room) -> Candidates:
        """Return the places where the UAV has its comfort, and those that show what no such place does.

        At the latter a photograph costs more: collision avoidance pushes the UAV about.
        """
        asked = self._asked
        if asked.comfort <= asked.margin:
            return self
        lack_m = asked.radius + asked.comfort - room.clearances_m(self.places_m)
        fewer, kept = self.preferring(lack_m <= 0.0)
        fewer.costs = np.clip(1.0 + COST_PER_M * lack_m[kept], 1.0, COST_MOST)
        return fewer

    def best(self, chosen: np.ndarray, worth: np.ndarray) -> np.ndarray:
        """Return (k, 3) gain, yaw and tilt, rad, of the best photograph from each chosen place."""
        p = self.patches
        return best_views(
            np.asarray(chosen, np.int64), self.places_m, self.begins, self.seen, self.bins, p.points_m,
            p.normals, worth, self.lens, self._tilts, *self._frames,
        )  # fmt: skip

    def likely_gains(self, chosen: np.ndarray, worth: np.ndarray) -> np.ndarray:
        """Return (k,) about how much the best photograph from each chosen place gains, seldom too little."""
        return likely_gains(
            np.asarray(chosen, np.int64), self.begins, self.seen, self.bins, worth, *self._frames
        )

    def drawn(self, place: int, yaw: float, tilt: float) -> np.ndarray:
        """Return the patches that a photograph from a place draws."""
        seen = self.seen[self.begins[place] : self.begins[place + 1]]
        p = self.patches
        return drawn_from(self.places_m[place], axes_of(yaw, tilt), self.lens, seen, p.points_m, p.normals)
