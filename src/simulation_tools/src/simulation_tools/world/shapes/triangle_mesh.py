"""Triangles in space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simulation_tools.geometry import Pose


@dataclass(frozen=True)
class TriangleMesh:
    """vertices: float64 (n, 3), metres; triangles: int32 (m, 3), indices of vertices."""

    vertices: np.ndarray
    triangles: np.ndarray

    def transformed(self, pose: Pose) -> TriangleMesh:
        """Return the mesh in the parent frame of a pose."""
        return TriangleMesh(pose.transform(self.vertices), self.triangles)

    @property
    def radius_m(self) -> float:
        """Radius of the smallest sphere about the centre of the bounding box that holds every vertex."""
        return float(np.linalg.norm(self.vertices - self.centre_m, axis=1).max())

    @property
    def centre_m(self) -> np.ndarray:
        """Centre of the bounding box, (3,)."""
        return 0.5 * (self.vertices.min(axis=0) + self.vertices.max(axis=0))


def joined(meshes: list[TriangleMesh]) -> TriangleMesh:
    """Put meshes of one frame into one."""
    counts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
    return TriangleMesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.triangles + start for mesh, start in zip(meshes, counts)]).astype(np.int32),
    )
