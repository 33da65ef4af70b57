"""What photographs show from where the camera really was.

It does not use the planner's geometry. The surface is known by points that are spread evenly over it. A
photograph shows a point if it is in the picture, near enough, not too flat, if the picture is neither white
nor black there, and if nothing hides it from the camera: Embree casts the ray. So the area that is shown is
known without bias, however narrow what is hidden.
"""

from __future__ import annotations

from typing import Sequence

import numpy as np

from inspection.camera.photograph_pose import PhotographPose
from inspection.camera.survey_camera import SurveyCamera
from inspection.photographs.exposure import at, exposed
from inspection.survey.parameters import SurveyParameters
from inspection.survey.surface.mesh_file import Mesh
from inspection.survey.surface.patches import Patches
from inspection.survey.surface.rays import Rays
from inspection.survey.surface.samples import SurfacePoints

CELL_M = 1.0
"""Points are looked for in cubes of this side."""
STEP_PX = 0.01
"""Between two lines of sight by which the width of a pixel is known."""
OFF_SURFACE_M = 1e-3
"""A ray to the camera begins so far before the surface."""


class Showing:
    """Tells which points of a surface photographs show.

    Args:
        mesh: all that hides. points: of it; or patches, for each of which its point stands. camera, asked: of
            the photographs.
    """

    def __init__(
        self, mesh: Mesh, points: SurfacePoints | Patches, camera: SurveyCamera, asked: SurveyParameters
    ) -> None:
        self._rays = Rays(mesh.triangles_m)
        self._points, self._camera, self._asked = points, camera, asked
        self._farthest_m = camera.distance_m(asked.resolution) * camera.longest_ray
        cells = np.floor(points.points_m / CELL_M).astype(np.int64)
        self._order = np.lexsort(cells.T)
        ordered = cells[self._order]
        self._starts = np.flatnonzero(np.append(True, (ordered[1:] != ordered[:-1]).any(axis=1)))
        self._ends = np.append(self._starts[1:], len(ordered))
        self._middles_m = (ordered[self._starts] + 0.5) * CELL_M

    def by(self, taken: Sequence[PhotographPose]) -> np.ndarray:
        """Return which points (n,) some photograph shows at the asked resolution and incidence."""
        shown = np.zeros(len(self._points), bool)
        for each in taken:
            self.add(each, shown)
        return shown

    def add(self, each: PhotographPose, shown: np.ndarray) -> None:
        """Set which points (n,) a photograph shows; those that are set already stay so."""
        near = self._near(each)
        near = near[~shown[near]]
        rays = self._points.points_m[near] - each.place_m
        lengths_m = np.linalg.norm(rays, axis=1)
        normals = self._points.normals[near]
        steep = -(rays * normals).sum(axis=1) >= np.cos(np.radians(self._asked.incidence)) * lengths_m
        near, rays, lengths_m, normals = (v[steep] for v in (near, rays, lengths_m, normals))
        pixels, drawn = self._camera.drawn(rays @ each.axes)
        near, rays, lengths_m, normals, pixels = (v[drawn] for v in (near, rays, lengths_m, normals, pixels))
        depth_m = rays @ each.axes[:, 2]
        footprint_m = _footprints_m(rays / depth_m[:, None], normals, depth_m, self._beside(pixels, each))
        widths_m = each.widths_m(footprint_m, depth_m, lengths_m / depth_m)
        fine = 1e3 * widths_m <= self._asked.resolution
        near, rays, lengths_m, normals = (v[fine] for v in (near, rays, lengths_m, normals))
        if each.path is not None:
            told = at(exposed(each.path), pixels[fine])
            near = near[told]
        shown[near[self._is_free(near, each.place_m)]] = True

    def _beside(self, pixels: np.ndarray, each: PhotographPose) -> list[np.ndarray]:
        """Return the lines of sight (k, 3), at depth 1, STEP_PX to the right of pixels, and below them."""
        steps = np.eye(2) * STEP_PX
        return [self._camera.rays(pixels + step) @ each.axes.T for step in steps]

    def _near(self, each: PhotographPose) -> np.ndarray:
        """Return the points in cubes that are near enough, and not behind the camera."""
        off_m = self._middles_m - each.place_m
        half_m = 0.5 * np.sqrt(3.0) * CELL_M
        reaches = (off_m**2).sum(axis=1) <= (self._farthest_m + half_m) ** 2
        reaches &= off_m @ each.axes[:, 2] >= -half_m
        runs = [self._order[a:b] for a, b in zip(self._starts[reaches], self._ends[reaches])]
        return np.concatenate(runs) if runs else np.zeros(0, np.int64)

    def _is_free(self, near: np.ndarray, place_m: np.ndarray) -> np.ndarray:
        """Return whether nothing stands between points (k,) and the camera."""
        begins_m = self._points.points_m[near] + OFF_SURFACE_M * self._points.normals[near]
        rays = place_m - begins_m
        lengths_m = np.linalg.norm(rays, axis=1)
        free: np.ndarray = (
            self._rays.ranges_m(begins_m, rays / lengths_m[:, None]) >= lengths_m - OFF_SURFACE_M
        )
        return free


def _footprints_m(
    rays: np.ndarray, normals: np.ndarray, depth_m: np.ndarray, beside: Sequence[np.ndarray]
) -> np.ndarray:
    """Return (k,) how much surface a pixel covers in its worst direction.

    beside: two of (k, 3), lines of sight STEP_PX to the right and below.
    """
    reach = (rays * normals).sum(axis=1) * depth_m
    points = rays * depth_m[:, None]
    edges = []
    for line in beside:
        edges.append((line * (reach / (line * normals).sum(axis=1))[:, None] - points) / STEP_PX)
    right, down = edges
    squares = (right**2).sum(axis=1), (down**2).sum(axis=1)
    apart = np.hypot(0.5 * (squares[0] - squares[1]), (right * down).sum(axis=1))
    worst_m: np.ndarray = np.sqrt(0.5 * (squares[0] + squares[1]) + apart)  # the greatest singular value
    return worst_m
