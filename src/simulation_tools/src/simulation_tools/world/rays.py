"""Casts rays: Embree scenes of all shapes.

All static shapes form one scene in world coordinates, built once. A shape that moves has its own small scene
in its own coordinates, also built once. So a motion costs nothing. The few rays that pass near it are
transformed to its frame. This is exact, and cheaper than a new scene for every scan.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Mapping, Sequence

import numpy as np
from embreex.mesh_construction import TriangleMesh as EmbreeMesh
from embreex.rtcore_scene import EmbreeScene

from kernel_cache.compiler import njit
from simulation_tools.geometry import Pose, rotate
from simulation_tools.world.shapes.triangle_mesh import TriangleMesh, joined

PoseSource = Callable[[], Pose]


@dataclass(frozen=True)
class _MovingShape:
    """A rigid mesh, its scene in its own frame, and the sphere around it (in its own frame too)."""

    scene: EmbreeScene
    pose: PoseSource
    centre_m: tuple[float, float, float]
    radius_m: float


class RayScene:
    """The shapes of every model, by the model's name."""

    def __init__(self) -> None:
        self._static: dict[str, TriangleMesh] = {}
        self._moving: dict[str, list[_MovingShape]] = {}
        self._static_scenes: dict[str | None, EmbreeScene | None] = {}

    def put(
        self,
        model: str,
        standing: TriangleMesh | None,
        moving: Sequence[tuple[TriangleMesh, PoseSource]] = (),
    ) -> None:
        """Put a model, or replace it.

        standing: the mesh of all fixed shapes, in world coordinates. moving: rigid meshes in their own
        frames, each with a function that returns its pose in the world.
        """
        self.remove(model)
        if standing is not None:
            self._static[model] = standing
            self._static_scenes.clear()
        if moving:
            self._moving[model] = [
                _MovingShape(_scene_of(mesh), source, tuple(mesh.centre_m.tolist()), mesh.radius_m)
                for mesh, source in moving
            ]

    def remove(self, model: str) -> None:
        """Take a model away; an unknown name does nothing."""
        self._moving.pop(model, None)
        if self._static.pop(model, None) is not None:
            self._static_scenes.clear()

    @property
    def standing(self) -> Mapping[str, TriangleMesh]:
        """The meshes of all fixed shapes by the model's name, in world coordinates."""
        return self._static

    def commit(self) -> None:
        """Build the static scene now rather than at the next ray."""
        self.static_scene(None)

    def cast(
        self, origins: np.ndarray, directions: np.ndarray, max_range_m: float, ignore_model: str | None = None
    ) -> np.ndarray:
        """Return the distance to the nearest surface along each ray.

        origins: (n, 3) or one common origin (3,), world frame; directions: (n, 3) unit vectors; ignore_model:
        rays pass through it. Returns float32 (n,), inf where nothing is nearer than max_range_m. Both sides
        of a surface are hit; a ray that starts inside a shape sees its far wall. Raises ValueError if the
        number of origins is neither 1 nor n.
        """
        directions = np.ascontiguousarray(directions, np.float32)
        given = np.ascontiguousarray(origins, np.float64).reshape(-1, 3)
        origins, ranges = np.empty_like(directions), np.empty(len(directions), np.float32)
        if not len(directions):
            return ranges
        if len(given) not in (1, len(directions)):
            raise ValueError(f"{len(directions)} rays cannot start at {len(given)} origins.")
        longest_m = np.float32(max_range_m)
        _begin(given, longest_m, origins, ranges)
        static = self.static_scene(ignore_model if ignore_model in self._static else None)
        if static is not None:
            static.run(origins, directions, ranges, query="DISTANCE")
        for model, shapes in self._moving.items():
            if model != ignore_model:
                for shape in shapes:
                    _cast_into(shape, origins, directions, ranges)
        _end(ranges, longest_m)
        return ranges

    def static_scene(self, without: str | None = None) -> EmbreeScene | None:
        """Return Embree's scene of all fixed shapes except one model's; None if there is none."""
        if without not in self._static_scenes:
            meshes = [mesh for name, mesh in self._static.items() if name != without]
            self._static_scenes[without] = _scene_of(joined(meshes)) if meshes else None
        return self._static_scenes[without]


@njit(cache=True)
def _begin(given: np.ndarray, longest_m: np.float32, origins: np.ndarray, ranges: np.ndarray) -> None:
    """Fill what Embree takes: an origin (n, 3) for each ray, single precision, and as ranges the longest.

    given: (n, 3), or one for all, (1, 3).
    """
    step = 1 if len(given) == ranges.size else 0
    for i in range(ranges.size):
        for axis in range(3):
            origins[i, axis] = given[i * step, axis]
        ranges[i] = longest_m


@njit(cache=True)
def _end(ranges: np.ndarray, longest_m: np.float32) -> None:
    """Make each range (n,) inf on whose way nothing was hit."""
    for i in range(ranges.size):
        ranges[i] = np.inf if ranges[i] >= longest_m else ranges[i]


def _scene_of(mesh: TriangleMesh) -> EmbreeScene:
    scene = EmbreeScene(robust=True)  # watertight: no ray slips through between two triangles
    EmbreeMesh(scene, mesh.vertices.astype(np.float32), np.ascontiguousarray(mesh.triangles, np.int32))
    # The first query builds the scene. Do it here, so that the first scan is not late.
    scene.run(np.zeros((1, 3), np.float32), np.array(((0.0, 0.0, 1.0),), np.float32), query="DISTANCE")
    return scene


def _cast_into(shape: _MovingShape, origins: np.ndarray, directions: np.ndarray, ranges: np.ndarray) -> None:
    """Shorten the ranges of the rays that hit a moving shape."""
    pose = shape.pose()
    x, y, z = rotate(pose.orientation_xyzw, shape.centre_m)
    px, py, pz = pose.position_m
    near = _rays_near(np.array((x + px, y + py, z + pz)), shape.radius_m, origins, directions, ranges)
    if not len(near):
        return
    turn = pose.rotation.astype(np.float32)
    # Row vectors: v @ R is R^T v, from the world into the shape's frame.
    local_origins = np.ascontiguousarray((origins[near] - np.array(pose.position_m, np.float32)) @ turn)
    local_directions = np.ascontiguousarray(directions[near] @ turn)
    shortened = np.ascontiguousarray(ranges[near])
    shape.scene.run(local_origins, local_directions, shortened, query="DISTANCE")
    ranges[near] = shortened


def _rays_near(
    centre: np.ndarray, radius_m: float, origins: np.ndarray, directions: np.ndarray, ranges: np.ndarray
) -> np.ndarray:
    """Return the indices of the rays that pass through a sphere before their range ends."""
    # Slightly more than the radius, so that single precision does not lose a grazing ray.
    radius = 1.001 * radius_m + 1e-3
    to_centre = centre.astype(np.float32) - origins
    distance_squared = np.einsum("ij,ij->i", to_centre, to_centre)
    along = np.einsum("ij,ij->i", to_centre, directions)
    ahead = (along > 0.0) & (distance_squared - along * along <= radius * radius) & (along - radius < ranges)
    return np.flatnonzero(ahead | (distance_squared <= radius * radius))
