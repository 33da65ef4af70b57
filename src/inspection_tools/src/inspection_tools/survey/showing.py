"""What photographs show from where the camera really was.

It does not use the planner's geometry. Embree casts rays through pixels of each photograph. The footprint
of a pixel comes from where its neighbours' rays meet the plane of the triangle that was hit.
"""

from __future__ import annotations

from typing import Sequence

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from inspection_tools.survey.camera import SurveyCamera
from inspection_tools.survey.parameters import SurveyParameters
from inspection_tools.survey.poses import Taken
from inspection_tools.survey.surface.mesh_file import Mesh
from inspection_tools.survey.surface.patches import Patches
from inspection_tools.survey.surface.samples import normals_of

RAYS_PER_PATCH = 4
"""Rays along the side of a patch that is as far away as the resolution allows."""


class Showing:
    """Tells which patches photographs show.

    Args:
        mesh: all that hides. patches: of it. camera, asked: of the photographs.
    """

    def __init__(self, mesh: Mesh, patches: Patches, camera: SurveyCamera, asked: SurveyParameters) -> None:
        self._scene = EmbreeScene()
        TriangleMesh(self._scene, np.ascontiguousarray(mesh.triangles_m, dtype=np.float32))
        self._normals, _ = normals_of(mesh.triangles_m)
        self._parts, self._patches, self._camera, self._asked = mesh.part, patches, camera, asked
        step_px = max(1, int(1e3 * patches.grid.side_m / (RAYS_PER_PATCH * asked.resolution)))
        self._lines = _lines_of_sight(camera, step_px)

    def by(self, taken: Sequence[Taken]) -> np.ndarray:
        """Return which patches (n,) some photograph shows at the asked resolution and incidence."""
        shown = np.zeros(len(self._patches), bool)
        for each in taken:
            found = self._in(each)
            shown[found[found >= 0]] = True
        return shown

    def _in(self, each: Taken) -> np.ndarray:
        """Return the patches (k,) at rays that are fine and steep enough; -1: of none."""
        rays = self._lines @ each.axes.T
        lengths = np.linalg.norm(rays, axis=1)
        origins = np.broadcast_to(each.place_m.astype(np.float32), rays.shape)
        hits = self._scene.run(
            np.ascontiguousarray(origins), (rays / lengths[:, None]).astype(np.float32), output=True
        )
        hit = np.flatnonzero(hits["primID"] >= 0)
        triangles = hits["primID"][hit]
        towards = self._normals[triangles]
        towards = towards * -np.sign((towards * rays[hit]).sum(axis=1))[:, None]
        cosine = -(towards * rays[hit]).sum(axis=1) / lengths[hit]
        depth_m = hits["tfar"][hit] / lengths[hit]
        footprint_m = _footprints_m(rays[hit], towards, depth_m, each.axes, self._camera.focal_px)
        fine = 1e3 * each.widths_m(footprint_m, depth_m, lengths[hit]) <= self._asked.resolution
        fine &= cosine >= np.cos(np.radians(self._asked.incidence))
        places_m = each.place_m + depth_m[fine, None] * rays[hit[fine]]
        return self._patches.numbers(places_m, towards[fine], self._parts[triangles[fine]])


def _lines_of_sight(camera: SurveyCamera, step_px: int) -> np.ndarray:
    """Return (k, 3) the lines of sight of every such pixel, at depth 1 in the optical frame."""
    right, down = np.meshgrid(
        np.arange(step_px // 2, camera.width, step_px), np.arange(step_px // 2, camera.height, step_px)
    )
    places = (np.column_stack((right.ravel(), down.ravel())) - camera.centre_px) / camera.focal_px
    return np.column_stack((places, np.ones(len(places))))


def _footprints_m(
    rays: np.ndarray, normals: np.ndarray, depth_m: np.ndarray, axes: np.ndarray, focal_px: float
) -> np.ndarray:
    """Return (k,) how much surface a pixel covers in its worst direction, by its neighbours' rays."""
    reach = (rays * normals).sum(axis=1) * depth_m
    points = rays * depth_m[:, None]
    edges = []
    for axis in (0, 1):
        beside = rays + 1e-3 * axes[:, axis] / focal_px
        edges.append(1e3 * (beside * (reach / (beside * normals).sum(axis=1))[:, None] - points))
    spread = np.stack(edges, axis=2)
    return np.linalg.svd(spread, compute_uv=False)[:, 0]
