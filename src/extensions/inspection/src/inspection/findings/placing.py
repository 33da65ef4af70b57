"""Places candidates on a mesh, by the pose of their photograph and rays."""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np

from inspection.camera.photograph_pose import PhotographPose
from inspection.camera.survey_camera import SurveyCamera
from inspection.findings.kinds import kind_of
from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import Candidate
from inspection.findings.sight import Sight
from inspection.survey.surface.rays import Rays

SHARE = 0.5
"""Of what a pose may be off by the parameters: their standard deviation."""
HIDDEN_M = 0.05
"""A point that is so far from where its ray ends is hidden."""


class Placed(NamedTuple):
    """A candidate on the surface. points_m: (n, 3) in the map. normal: (3,). area_m2: of all its pixels.

    detail_mm: that a pixel covers there in the worst direction, median. eye_m: (3,) of the camera. off_m:
    standard deviation of the place.
    """

    kind: str
    points_m: np.ndarray
    normal: np.ndarray
    area_m2: float
    photograph: str
    detail_mm: float
    eye_m: np.ndarray
    off_m: float = 0.0


class MeshSurface:
    """Triangles (m, 3, 3) in the map's frame, and rays on them."""

    def __init__(self, triangles_m: np.ndarray) -> None:
        normals = np.cross(triangles_m[:, 1] - triangles_m[:, 0], triangles_m[:, 2] - triangles_m[:, 0])
        self._normals = normals / np.maximum(np.linalg.norm(normals, axis=1)[:, None], 1e-12)
        self._rays = Rays(triangles_m)

    def hits(self, eye_m: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return points (n, 3), NaN where unit rays hit nothing, and normals (n, 3) to the eye."""
        triangles, far_m = self._rays.hits(eye_m, rays)
        far = np.where(triangles >= 0, far_m, np.nan)
        normals = self._normals[triangles]
        normals = np.where((normals * rays).sum(axis=1)[:, None] > 0.0, -normals, normals)
        return eye_m + far[:, None] * rays, normals


class PosedPhotograph:
    """A photograph's rays on the surface. taken: its pose. name: of its file.

    focal_deviation: of the camera's focal length, a share.
    """

    def __init__(
        self,
        surface: MeshSurface,
        camera: SurveyCamera,
        taken: PhotographPose,
        parameters: FindingParameters,
        name: str,
        focal_deviation: float = 0.0,
    ) -> None:
        self._surface, self._camera, self._p, self._name = surface, camera, parameters, name
        self._eye_m, self._turn = taken.place_m, taken.axes
        self._off_m = math.hypot(taken.off_m, SHARE * parameters.pose_off)
        self._off_rad = math.hypot(taken.off_rad, SHARE * math.radians(parameters.pose_turned))
        self._focal_deviation = focal_deviation

    @cached_property
    def sight(self) -> Sight:
        """What it should show of the surface; some 300,000 rays tell it."""
        return Sight(self._look, self._eye_m, self._camera, self._p)

    def _look(self, pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        rays = self._camera.rays(pixels) @ self._turn.T
        rays /= np.linalg.norm(rays, axis=1)[:, None]
        return (*self._surface.hits(self._eye_m, rays), rays)

    def place(self, candidate: Candidate) -> Placed | None:
        """Return the candidate on the surface; None if it is too small, flat or far, or an edge."""
        p, kind = self._p, kind_of(candidate.kind)
        if kind.is_line and self.sight.is_edge(candidate.pixels):
            return None
        points, normals, rays = self._look(candidate.pixels)
        far = np.linalg.norm(points - self._eye_m, axis=1)
        steep = -(normals * rays).sum(axis=1)
        good = (far < p.distance) & (steep > np.cos(np.radians(p.incidence)))  # NaN is not good
        if good.sum() < 3 or good.mean() < 0.3:
            return None
        pixel_m2 = self._pixels_m2(candidate.pixels[good], points[good], normals[good])
        area = float(pixel_m2.mean() * candidate.size_px * good.mean())
        detail_mm = float(np.median(1e3 * far[good] / self._camera.focal_px / steep[good]))
        normal, off_m = normals[good].mean(axis=0), self._deviation_m(points[good])
        placed = Placed(kind.name, points[good], normal, area, self._name, detail_mm, self._eye_m, off_m)
        return placed if kind.is_large_enough(extent(placed.points_m)[1], area, p) else None

    def _deviation_m(self, points_m: np.ndarray) -> float:
        """Return how far points (n, 3) may be off, by the camera's place, direction and lens."""
        away_m = (points_m.mean(axis=0) - self._eye_m) @ self._turn
        aside_m, far_m = float(np.hypot(*away_m[:2])), float(np.linalg.norm(away_m))
        return math.hypot(self._off_m, far_m * self._off_rad, aside_m * self._focal_deviation)

    def _pixels_m2(self, pixels: np.ndarray, points_m: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Return (n,) the area of the surface that pixels (n, 2) cover, by the rays at their sides."""
        reach_m = ((points_m - self._eye_m) * normals).sum(axis=1)

        def met_m(step: tuple[float, float]) -> np.ndarray:
            rays = self._camera.rays(pixels + np.array(step)) @ self._turn.T
            met: np.ndarray = rays * (reach_m / (rays * normals).sum(axis=1))[:, None]
            return met

        across, down = (met_m((x, y)) - met_m((-x, -y)) for x, y in ((0.5, 0.0), (0.0, 0.5)))
        area_m2: np.ndarray = np.linalg.norm(np.cross(across, down), axis=1)
        return area_m2

    def share_judged(self, points_m: np.ndarray, detail_mm: float) -> float:
        """Return the share of points (n, 3) that lie where cracks are looked for, at this detail or finer."""
        camera = self._camera
        pixels, inside = camera.drawn((points_m - self._eye_m) @ self._turn)
        if not inside.any():
            return 0.0
        hits, normals, rays = self._look(pixels[inside])
        far = np.linalg.norm(hits - self._eye_m, axis=1)
        steep = -(normals * rays).sum(axis=1)
        good = np.linalg.norm(hits - points_m[inside], axis=1) < HIDDEN_M
        good &= 1e3 * far / camera.focal_px <= detail_mm * np.maximum(steep, 1e-6)
        good &= self.sight.judges(pixels[inside])
        return float(good.sum() / len(points_m))


def extent(points_m: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the middle (3,) between the ends of points (n, 3), and their length."""
    mean = points_m.mean(axis=0)
    _, _, axes = np.linalg.svd(points_m - mean, full_matrices=False)
    along = (points_m - mean) @ axes.T
    low, high = along.min(axis=0), along.max(axis=0)
    return mean + 0.5 * (low + high) @ axes, float(high[0] - low[0])
