"""The true surfaces of a world, as triangles with the names of the things that they belong to."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from gridslam.errors import EvaluationError, reason_of

CANDIDATES = 4
"""Triangles that are compared for each point: those of the nearest samples."""
CHUNK = 50_000
WORLD_SUFFIXES = (".world", ".sdf")
READING_S = 600.0
"""Wall time in which a world is read."""


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
    """Read an SDF world, or a mesh that trimesh knows (STL, OBJ, PLY, GLB, DAE). z is up.

    COLLADA and 3MF tell their unit; others are in metres.

    Raises:
        EvaluationError: the file cannot be read, or has no surface.
    """
    if not path.is_file():
        raise EvaluationError(f"{path}: there is no such file. Give an SDF world or a mesh.")
    if path.suffix.lower() in WORLD_SUFFIXES:
        with tempfile.TemporaryDirectory() as folder:
            return _read_mesh(_mesh_of_world(path, Path(folder) / "world.glb"))
    return _read_mesh(path)


def _mesh_of_world(world: Path, mesh: Path) -> Path:
    """Let `simulation_tools` write the mesh of a world: it alone reads SDF."""
    command = [sys.executable, "-m", "simulation_tools.world.mesh_file", str(world), str(mesh)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=READING_S)
    except subprocess.TimeoutExpired:
        raise EvaluationError(f"{world}: its surfaces were not read within {READING_S:g} s.") from None
    if done.returncode:
        told = (done.stderr.strip().splitlines() or ["simulation_tools did not say why."])[-1]
        raise EvaluationError(f"{world}: its surfaces cannot be read. {told}")
    return mesh


def _read_mesh(path: Path) -> Surface:
    try:
        scene: Any = trimesh.load_scene(path)
        metres = trimesh.units.unit_conversion(scene.units, "meters") if scene.units else 1.0
    except Exception as error:  # trimesh's loaders raise whatever their formats' libraries raise
        raise EvaluationError(f"{path}: cannot be read as a mesh ({reason_of(error)}).") from error
    names: list[str] = []
    triangles, part = [], []
    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        mesh = scene.geometry[geometry]
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            corners = trimesh.transform_points(mesh.vertices, transform)[mesh.faces]
            part.append(np.full(len(corners), len(names)))
            triangles.append(metres * corners)
            names.append(str(node))
    if not triangles:
        raise EvaluationError(f"{path}: there is no surface in it.")
    return Surface(np.concatenate(triangles), tuple(names), np.concatenate(part))
