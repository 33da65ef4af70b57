"""A world seen from above, drawn from its SDF: the outline and the height of every solid shape."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import Box, Cylinder, Geometry, Mesh, Polyline, Sphere, World
from simulation_tools.sdf.parser import load_world
from simulation_tools.world.shapes.convex_parts import connected_pieces
from simulation_tools.world.shapes.extrusion import prisms
from simulation_tools.world.shapes.meshes import readable_mesh_of

MANY = 200
_CIRCLE = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)


@dataclass(frozen=True)
class Outline:
    """A shape from above. outline_xy: corners (n, 2) in `world`; bottom_m, top_m: its extent in height."""

    name: str
    outline_xy: np.ndarray
    bottom_m: float
    top_m: float

    def blocks(self, height_m: float) -> bool:
        """Return whether the shape blocks this height."""
        return self.bottom_m <= height_m <= self.top_m


def outlines_of_file(world_file: Path | str) -> list[Outline]:
    """Return the outlines of the world in an SDF file; raises SimulationToolsError when it cannot be read."""
    return outlines(load_world(str(world_file)))


def outlines(world: World) -> list[Outline]:
    """Return the outlines of all collision shapes of a world except the ground's, in the file's order.

    An outline is the convex hull of the shape's points from above. A mesh has a hull for each connected
    piece; one whose file cannot be used has none, as in the simulator. Planes and heightmaps are ground.
    """
    found = []
    for model in world.models:
        for link in model.links:
            for collision in link.collisions:
                pose = model.pose @ link.pose @ collision.pose
                name = f"{model.name}::{link.name}::{collision.name}"
                for points in _point_clouds(collision.geometry):
                    found.append(_outline(name, pose, points))
    return found


def _outline(name: str, pose: Pose, points: np.ndarray) -> Outline:
    placed = pose.transform(points)
    return Outline(name, convex_hull(placed[:, :2]), float(placed[:, 2].min()), float(placed[:, 2].max()))


def _point_clouds(geometry: Geometry) -> list[np.ndarray]:
    """Return points (n, 3) whose hull is the shape, one array for each convex piece."""
    if isinstance(geometry, Box):
        corners = np.array(np.meshgrid((-0.5, 0.5), (-0.5, 0.5), (-0.5, 0.5))).reshape(3, -1).T
        return [corners * np.array(geometry.size_m)]
    if isinstance(geometry, Cylinder):
        ring = _ring(geometry.radius_m)
        half = np.array([0.0, 0.0, geometry.length_m / 2])
        return [np.concatenate((ring - half, ring + half))]
    if isinstance(geometry, Sphere):
        radius = geometry.radius_m
        latitudes = np.linspace(-np.pi / 2, np.pi / 2, 25)
        return [np.concatenate([_ring(radius * np.cos(a), radius * np.sin(a)) for a in latitudes])]
    if isinstance(geometry, Mesh):
        return _mesh_pieces(geometry)
    if isinstance(geometry, Polyline):
        return [] if readable_mesh_of(geometry) is None else prisms(geometry)
    return []  # a plane or a heightmap


def _ring(radius_m: float, height_m: float = 0.0) -> np.ndarray:
    ring = np.zeros((len(_CIRCLE), 3))
    ring[:, 0], ring[:, 1], ring[:, 2] = radius_m * np.cos(_CIRCLE), radius_m * np.sin(_CIRCLE), height_m
    return ring


def _mesh_pieces(geometry: Mesh) -> list[np.ndarray]:
    mesh = readable_mesh_of(geometry)
    if mesh is None:
        return []
    return [mesh.vertices[np.unique(triangles)] for triangles in connected_pieces(mesh)]


def convex_hull(points_xy: np.ndarray) -> np.ndarray:
    """Return the corners (m, 2) of the convex hull of points (n, 2), counter-clockwise (Andrew, 1979)."""
    points = np.unique(np.round(points_xy, 9), axis=0)
    if len(points) > MANY:
        return _hull_of_many(points)
    if len(points) < 3:
        return points
    return np.array(_half_hull(points)[:-1] + _half_hull(points[::-1])[:-1])


def _hull_of_many(points: np.ndarray) -> np.ndarray:
    """Return the same by Qhull, which costs more for few points and far less for many."""
    from scipy.spatial import ConvexHull, QhullError  # slow to import, and few worlds need it

    try:
        return points[ConvexHull(points).vertices]
    except QhullError:  # all on one line
        along = points @ np.ptp(points, axis=0)
        return points[[along.argmin(), along.argmax()]]


def _half_hull(points: np.ndarray) -> list[np.ndarray]:
    hull: list[np.ndarray] = []
    for point in points:
        while len(hull) >= 2 and _turn(hull[-2], hull[-1], point) <= 0.0:
            hull.pop()
        hull.append(point)
    return hull


def _turn(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    """Twice the signed area of the triangle a b c; positive for a turn to the left."""
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
