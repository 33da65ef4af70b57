"""The surfaces that a camera sees: the triangles of a world's static shapes, put together to plane faces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping

import numpy as np
from embreex.mesh_construction import TriangleMesh as EmbreeMesh
from embreex.rtcore_scene import EmbreeScene

from simulation_tools.camera.errors import PhotographError
from simulation_tools.sdf.elements import World
from simulation_tools.world.shapes.meshes import readable_mesh_of


@dataclass(frozen=True)
class Surfaces:
    """Plane faces. Triangles in one plane are one face, of the last one's colour.

    scene: Embree's, of all triangles. face_of: (triangles,) number of each one's face. normals: (faces, 3).
    offsets_m: (faces,), normal . point. u_axes, v_axes: (faces, 3) unit vectors in the face; v points up
    where the face is not level. albedos: (faces, 3), linear, 0..1. A place on a face is (u . p, v . p), m.
    corners_m: (triangles, 3, 3) in the world.
    """

    scene: EmbreeScene
    face_of: np.ndarray
    normals: np.ndarray
    offsets_m: np.ndarray
    u_axes: np.ndarray
    v_axes: np.ndarray
    albedos: np.ndarray
    corners_m: np.ndarray

    def nearest(self, origins_m: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return (faces, distances in m) that rays (n, 3) hit; face -1 and distance inf where none."""
        hit = self.scene.run(_f32(origins_m), _f32(directions), output=1)
        found = hit["primID"] >= 0
        faces = np.where(found, self.face_of[hit["primID"]], -1).astype(np.int32)
        return faces, np.where(found, hit["tfar"], np.inf).astype(np.float32)


def surfaces_of(world: World, coatings: Mapping[str, tuple[float, float, float]] | None = None) -> Surfaces:
    """Return the surfaces of a world's models that do not move.

    coatings: sRGB colours, 0..1, by the model's name, in place of those of the file.

    Raises:
        PhotographError: the world has no surface.
    """
    corners, colours = [], []
    for model in world.models:
        paint = None if coatings is None else coatings.get(model.name)
        for link in model.links if model.static else ():
            for visual in link.visuals:
                shape = readable_mesh_of(visual.geometry)
                if shape is None:  # the simulator leaves it out too, and says so
                    continue
                mesh = shape.transformed(model.pose @ link.pose @ visual.pose)
                corners.append(mesh.vertices[mesh.triangles])
                colours.append(np.tile(paint or visual.rgba[:3], (len(mesh.triangles), 1)))
    if not corners:
        raise PhotographError(f"{world.source}: The world has no fixed visual shape to photograph.")
    return _faces(np.concatenate(corners), linear(np.concatenate(colours)))


def linear(srgb: np.ndarray) -> np.ndarray:
    """Return linear light of sRGB values, both 0..1."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def _faces(corners: np.ndarray, colours: np.ndarray) -> Surfaces:
    """corners: (n, 3, 3), m. colours: (n, 3)."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    corners, colours, normals = corners[lengths > 0], colours[lengths > 0], normals[lengths > 0]
    normals /= lengths[lengths > 0, None]
    offsets = np.einsum("ij,ij->i", normals, corners[:, 0])
    # Two shapes may share a plane; the ray then hits either. One colour, the later shape's, avoids speckles.
    corners, colours, normals, offsets = corners[::-1], colours[::-1], normals[::-1], offsets[::-1]
    keys = np.round(np.column_stack((1e4 * normals, 1e3 * offsets))) + 0.0
    _, first, face_of = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    scene = EmbreeScene(robust=True)
    vertices = _f32(corners.reshape(-1, 3))
    EmbreeMesh(scene, vertices, np.arange(len(vertices), dtype=np.int32).reshape(-1, 3))
    up = np.array((0.0, 0.0, 1.0))
    level = np.abs(normals[first, 2]) > 0.99
    u = np.where(level[:, None], (1.0, 0.0, 0.0), np.cross(up, normals[first]))
    u -= np.einsum("ij,ij->i", u, normals[first])[:, None] * normals[first]
    u /= np.linalg.norm(u, axis=1)[:, None]
    v = np.cross(normals[first], u)
    return Surfaces(
        scene, face_of.ravel().astype(np.int32), normals[first], offsets[first], u, v, colours[first],
        vertices.reshape(-1, 3, 3),
    )  # fmt: skip


def _f32(values: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(values, np.float32)
