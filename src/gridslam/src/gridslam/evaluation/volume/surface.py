"""The true surfaces of a world, as triangles with the names of the things that they belong to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from gridslam.errors import EvaluationError
from mesh_files.errors import MeshFileError
from mesh_files.worlds import read_triangles

CANDIDATES = 4
"""Triangles that are compared for each point: those of the nearest samples."""
CHUNK = 50_000
MOST_TRIANGLES = 20_000_000


@dataclass(frozen=True)
class Samples:
    """Points on a surface: points_m (n, 3); normals (n, 3), of unit length; triangles: (n,) their indices."""

    points_m: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray


class Surface:
    """Triangles in the world's frame.

    Attributes:
        triangles_m: (m, 3, 3) corners.
        names: of the things in it.
        part: (m,) for each triangle the index of its thing's name.
    """

    def __init__(self, triangles_m: np.ndarray, names: tuple[str, ...], part: np.ndarray):
        self.triangles_m, self.names, self.part = triangles_m, names, part
        edges = triangles_m[:, 1:] - triangles_m[:, :1]
        across = np.cross(edges[:, 0], edges[:, 1])
        self._areas_m2 = 0.5 * np.linalg.norm(across, axis=1)
        self._normals = across / np.maximum(2.0 * self._areas_m2[:, None], 1e-12)
        corners_m = triangles_m.reshape(-1, 3)
        self._middle_m = np.rint(0.5 * (corners_m.min(axis=0) + corners_m.max(axis=0)))
        self._scene = EmbreeScene()  # computes in float32, which tells places 100 km away to 8 mm only
        TriangleMesh(self._scene, np.ascontiguousarray(triangles_m - self._middle_m, dtype=np.float32))

    def samples(
        self, spacing_m: float, rng: np.random.Generator, low_m: ArrayLike, high_m: ArrayLike
    ) -> Samples:
        """Return points spread evenly at random over the surface in a box, one for each spacing_m squared."""
        low_m, high_m = np.asarray(low_m), np.asarray(high_m)
        lowest, highest = self.triangles_m.min(axis=1), self.triangles_m.max(axis=1)
        touches = ((lowest <= high_m) & (highest >= low_m)).all(axis=1)
        wanted = np.where(touches, self._areas_m2, 0.0) / spacing_m**2
        numbers = np.floor(wanted).astype(int)
        numbers += rng.random(len(numbers)) < wanted - numbers
        of = np.repeat(np.arange(len(numbers)), numbers)
        along = rng.random((len(of), 2))
        folded = along.sum(axis=1) > 1.0
        along[folded] = 1.0 - along[folded]
        corners = self.triangles_m[of]
        edges = corners[:, 1:] - corners[:, :1]
        points_m = corners[:, 0] + (along[:, :, None] * edges).sum(axis=1)
        kept = ((points_m >= low_m) & (points_m <= high_m)).all(axis=1)
        return Samples(points_m[kept], self._normals[of[kept]], of[kept])

    def distances_m(self, points_m: np.ndarray, samples: Samples) -> np.ndarray:
        """Return the distance (n,) of points (n, 3) from the nearest surface.

        It is exact if that surface has one of the nearest samples. Otherwise it is too large by less than
        half of the samples' spacing.
        """
        tree = cKDTree(samples.points_m)
        found = np.empty(len(points_m))
        for start in range(0, len(points_m), CHUNK):
            some = points_m[start : start + CHUNK]
            _, nearest = tree.query(some, k=min(CANDIDATES, len(samples.points_m)))
            near = samples.triangles[nearest.reshape(len(some), -1)]
            compared = np.repeat(some, near.shape[1], axis=0)
            closest = trimesh.triangles.closest_point(self.triangles_m[near.ravel()], compared)
            apart = np.linalg.norm(closest - compared, axis=1).reshape(near.shape)
            found[start : start + CHUNK] = apart.min(axis=1)
        return found

    def ranges_m(self, origins_m: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Return the distance (n,) to the first surface along rays of unit length, by Embree; inf: none."""
        hits = self._scene.run(
            np.ascontiguousarray(origins_m - self._middle_m, dtype=np.float32),
            np.ascontiguousarray(directions, dtype=np.float32),
            query="DISTANCE",
        )
        return np.where(hits > 1e20, np.inf, hits)

    def hits(self, origins_m: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the range (n,) of rays of unit length, inf: none, and the normal (n, 3) where they end."""
        found = self._scene.run(
            np.ascontiguousarray(origins_m - self._middle_m, dtype=np.float32),
            np.ascontiguousarray(directions, dtype=np.float32),
            output=True,
        )
        missed = found["primID"] < 0
        return np.where(missed, np.inf, found["tfar"]), self._normals[np.where(missed, 0, found["primID"])]


def read_surface(path: Path) -> Surface:
    """Read an SDF world, or a mesh of the kinds that `mesh_files` knows, in metres, z up.

    Raises:
        EvaluationError: the file cannot be read, or has no surface.
    """
    try:
        return Surface(*read_triangles(path, MOST_TRIANGLES))
    except MeshFileError as error:
        raise EvaluationError(f"{path}: {error}.") from None
