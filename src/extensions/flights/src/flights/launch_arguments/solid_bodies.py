"""Whether a place lies inside a solid that is drawn as a mesh: physics knows only its surface."""

from __future__ import annotations

from typing import Mapping

import numpy as np

from mesh_files.bodies import bodies_of
from simulation_tools.world.shapes.triangle_mesh import TriangleMesh

ASIDE_M = (1.3e-5, 2.9e-5, 0.0)
"""So the way up from a place meets no edge between two triangles, which places at the origin often do."""
BEYOND_M = 1.0
"""The world goes on outside of a solid if something reaches so far beyond the box around it."""


def solid_around(meshes: Mapping[str, TriangleMesh], place_m: np.ndarray) -> str | None:
    """Return the name of the model with a solid around a place (x, y, z); None: the place is in the air.

    A solid is a closed surface that faces outward, and the world goes on outside of it. A hall of one such
    surface, which holds all that the world has, is no solid: its faces are drawn the wrong way round.

    meshes: by name, in world coordinates.
    """
    place_m = np.asarray(place_m) + ASIDE_M
    inside = [name for name, mesh in meshes.items() if _winding(mesh, place_m) > 0]
    if not inside:
        return None
    corners_m = [each(mesh.vertices, axis=0) for mesh in meshes.values() for each in (np.min, np.max)]
    for name in inside:
        around = [(body, _winding(body, place_m)) for body in _closed_bodies(meshes[name])]
        boxes_m = [_box_m(body) for body, times in around if times > 0]
        if boxes_m and sum(times for _, times in around) > 0:
            low_m, high_m = min(boxes_m, key=lambda box_m: float(np.prod(box_m[1] - box_m[0])))
            if any((np.maximum(low_m - each, each - high_m) > BEYOND_M).any() for each in corners_m):
                return name
    return None


def _winding(mesh: TriangleMesh, place_m: np.ndarray) -> int:
    """Return how often a way straight up from a place leaves closed bodies, less how often it enters them.

    It is 1 inside of one body that faces outward, and 0 in a cavity of it.
    """
    a, b, c = (mesh.vertices[corner] - place_m for corner in mesh.triangles.T)
    turns = np.array([p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0] for p, q in ((b, c), (c, a), (a, b))])
    leaves, enters = (turns > 0.0).all(axis=0), (turns < 0.0).all(axis=0)
    is_above = (turns * (a[:, 2], b[:, 2], c[:, 2])).sum(axis=0) * np.sign(turns[0]) > 0.0
    return int((leaves & is_above).sum()) - int((enters & is_above).sum())


def _box_m(mesh: TriangleMesh) -> tuple[np.ndarray, np.ndarray]:
    corners_m = mesh.vertices[mesh.triangles.ravel()]
    return corners_m.min(axis=0), corners_m.max(axis=0)


def _closed_bodies(mesh: TriangleMesh) -> list[TriangleMesh]:
    """Return the connected parts of a mesh each of whose edges runs once in both directions."""
    bodies, is_closed = bodies_of(mesh.vertices[mesh.triangles])
    return [TriangleMesh(mesh.vertices, mesh.triangles[bodies == body]) for body in np.flatnonzero(is_closed)]
