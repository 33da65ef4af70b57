"""What a photograph is to show: the surface in it that is near enough and not too flat."""

from __future__ import annotations

import numpy as np

from inspection.camera.photograph_pose import PhotographPose
from inspection.camera.survey_camera import SurveyCamera
from inspection.survey.surface.mesh_file import Mesh
from inspection.survey.surface.rays import Rays

SIDE = 48
"""Points along the longer side of a picture by which it is known."""


class AskedFor:
    """Tells it of the photographs of one camera.

    Args:
        mesh: all that can be seen. incidence_deg: greatest one at which a surface counts as shown.
    """

    def __init__(self, mesh: Mesh, camera: SurveyCamera, incidence_deg: float) -> None:
        corners = mesh.triangles_m
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self._normals = across / np.maximum(np.linalg.norm(across, axis=1)[:, None], 1e-12)
        self._rays, self._camera = Rays(corners), camera
        self._least = np.cos(np.radians(incidence_deg))
        step = max(camera.width, camera.height) / SIDE
        x, y = np.meshgrid(
            np.arange(0.5 * step, camera.width, step), np.arange(0.5 * step, camera.height, step)
        )
        self._pixels = np.column_stack((x.ravel(), y.ravel()))
        self._lines = camera.rays(self._pixels)

    def of(self, taken: PhotographPose, detail_m: float) -> tuple[np.ndarray, np.ndarray]:
        """Return pixels (n, 2) of what a photograph is to show, and the areas, m2, that they stand for.

        detail_m: what a pixel covers there at most, in its worst direction.
        """
        lengths = np.linalg.norm(self._lines, axis=1)
        rays = self._lines @ taken.axes.T / lengths[:, None]
        triangles, ranges_m = self._rays.hits(taken.place_m, rays)
        facing = np.abs((self._normals[triangles] * rays).sum(axis=1))
        depths_m = np.where(triangles >= 0, ranges_m, 0.0) / lengths
        across_m = depths_m / self._camera.focal_px
        asked = (triangles >= 0) & (facing >= self._least) & (across_m <= detail_m * facing)
        areas_m2 = across_m[asked] ** 2 / (lengths[asked] * facing[asked])
        return self._pixels[asked], areas_m2
