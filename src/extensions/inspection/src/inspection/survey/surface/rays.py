"""Embree's rays on triangles that may lie far from the origin of their frame."""

from __future__ import annotations

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

NOTHING_M = 1e20
"""Embree tells a greater distance where a ray meets nothing."""


class Rays:
    """Triangles (m, 3, 3) and rays on them.

    Embree computes in float32, which tells places 100 km away to 8 mm only. So it gets all places from the
    middle of the triangles.
    """

    def __init__(self, triangles_m: np.ndarray) -> None:
        corners_m = np.asarray(triangles_m, float).reshape(-1, 3)
        self._middle_m = np.rint(0.5 * (corners_m.min(axis=0) + corners_m.max(axis=0)))
        self._scene = EmbreeScene()
        TriangleMesh(self._scene, np.ascontiguousarray(triangles_m - self._middle_m, dtype=np.float32))

    def ranges_m(self, origins_m: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Return the distance (n,) to the first triangle along rays of unit length; inf: none."""
        hits_m = self._scene.run(*self._given(origins_m, directions), query="DISTANCE")
        return np.where(hits_m > NOTHING_M, np.inf, hits_m)

    def hits(self, origins_m: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the first triangle (n,) along rays of unit length, -1: none, and its distance (n,)."""
        found = self._scene.run(*self._given(origins_m, directions), output=True)
        return found["primID"], np.where(found["primID"] >= 0, found["tfar"], np.inf)

    def _given(self, origins_m: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        begins_m = np.broadcast_to(origins_m - self._middle_m, directions.shape)
        return (
            np.ascontiguousarray(begins_m, dtype=np.float32),
            np.ascontiguousarray(directions, dtype=np.float32),
        )
