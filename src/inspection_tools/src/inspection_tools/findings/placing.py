"""Places candidates on a mesh, by the pose of their photograph and rays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from scipy.spatial.transform import Rotation

from inspection_tools.findings.candidates import Candidate
from inspection_tools.findings.parameters import FindingParameters
from inspection_tools.photographs.folder import PhotographRecord
from inspection_tools.survey.camera import SurveyCamera

STEP_M = 0.01
"""Two hits whose planes differ by more lie on two surfaces."""


class Placed(NamedTuple):
    """A candidate on the surface. points_m: (n, 3) in the map. normal: (3,). area_m2: of all its pixels."""

    kind: str
    points_m: np.ndarray
    normal: np.ndarray
    area_m2: float
    photograph: str


class MeshSurface:
    """Triangles (m, 3, 3) in the map's frame, and rays on them."""

    def __init__(self, triangles_m: np.ndarray) -> None:
        normals = np.cross(triangles_m[:, 1] - triangles_m[:, 0], triangles_m[:, 2] - triangles_m[:, 0])
        self._normals = normals / np.maximum(np.linalg.norm(normals, axis=1)[:, None], 1e-12)
        self._scene = EmbreeScene()
        TriangleMesh(self._scene, np.ascontiguousarray(triangles_m, np.float32))

    def hits(self, eye_m: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return points (n, 3), NaN where unit rays hit nothing, and normals (n, 3) to the eye."""
        origins = np.broadcast_to(eye_m, rays.shape)
        hit = self._scene.run(
            np.ascontiguousarray(origins, np.float32), np.ascontiguousarray(rays, np.float32), output=1
        )
        far = np.where(hit["primID"] >= 0, hit["tfar"], np.nan)
        normals = self._normals[hit["primID"]]
        normals = np.where((normals * rays).sum(axis=1)[:, None] > 0.0, -normals, normals)
        return eye_m + far[:, None] * rays, normals

    def place(
        self,
        candidate: Candidate,
        camera: SurveyCamera,
        record: PhotographRecord,
        parameters: FindingParameters,
        photograph: str,
    ) -> Placed | None:
        """Return the candidate on the surface; None if it is too small, flat or far, or an edge."""
        p, eye = parameters, np.array(record.position_m)
        turn = Rotation.from_quat(record.orientation_xyzw).as_matrix()

        def look(pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            aside = (pixels - camera.centre_px) / camera.focal_px
            rays = np.column_stack((aside, np.ones(len(aside)))) @ turn.T
            rays /= np.linalg.norm(rays, axis=1)[:, None]
            return (*self.hits(eye, rays), rays)

        points, normals, rays = look(candidate.pixels)
        far = np.linalg.norm(points - eye, axis=1)
        steep = -(normals * rays).sum(axis=1)
        good = (far < p.distance) & (steep > np.cos(np.radians(p.incidence)))  # NaN is not good
        if candidate.kind == "crack":
            for angle in np.arange(8) * np.pi / 4:
                off = p.keep_off * np.array((np.cos(angle), np.sin(angle)))
                beside, others, _ = look(candidate.pixels + off)
                good &= np.abs(((beside - points) * normals).sum(axis=1)) < STEP_M
                good &= (others * normals).sum(axis=1) > 0.95
        if good.sum() < 3 or good.mean() < 0.3:
            return None
        pixel_m2 = (far[good] / camera.focal_px) ** 2 / steep[good]
        area = float(pixel_m2.mean() * candidate.size_px * good.mean())
        placed = Placed(candidate.kind, points[good], normals[good].mean(axis=0), area, photograph)
        if candidate.kind == "crack":
            return placed if extent(placed.points_m)[1] >= p.crack_length else None
        return placed if area >= p.rust_size**2 else None


def extent(points_m: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the middle (3,) between the ends of points (n, 3), and their length."""
    mean = points_m.mean(axis=0)
    _, _, axes = np.linalg.svd(points_m - mean, full_matrices=False)
    along = (points_m - mean) @ axes.T
    low, high = along.min(axis=0), along.max(axis=0)
    return mean + 0.5 * (low + high) @ axes, float(high[0] - low[0])
