"""Where models touch, named as Gazebo names it: ``model::link::collision``."""

from __future__ import annotations

import math
from typing import Iterator, Mapping, NamedTuple, Sequence

from simulation_tools.geometry import Pose, Vector3
from simulation_tools.sdf.elements import Box, Cylinder, Geometry, Plane, Sphere
from simulation_tools.world.assembly import PlacedCollision
from simulation_tools.world.bodies import Body
from simulation_tools.world.engine import pybullet
from simulation_tools.world.kinematics import part_pose
from simulation_tools.world.shapes.meshes import mesh_of


class Contact(NamedTuple):
    """A point where two shapes touch, world frame.

    collision_1, collision_2: ``model::link::collision``, the asked model's first. normal: unit vector from
    the second shape towards the first. depth_m: how far they are inside each other. force_n: size of the
    normal force.
    """

    collision_1: str
    collision_2: str
    position_m: Vector3
    normal: Vector3
    depth_m: float
    force_n: float


def contacts_of(
    client: int,
    name: str,
    bodies: Sequence[Body],
    owners: Mapping[int, tuple[str, Body]],
) -> list[Contact]:
    """Return the contacts of one model's bodies with those of others.

    owners: the model's name and the body for each PyBullet uid. link_pose: pose of a body's part in the
    world.
    """
    found: list[Contact] = []
    for body in bodies:
        points = pybullet.getContactPoints(bodyA=body.uid, physicsClientId=client)
        if points:
            found += _contacts(_PartFrames(client), name, body, points, owners)
    return found


def _contacts(
    frames: _PartFrames,
    name: str,
    body: Body,
    points: Sequence[tuple],
    owners: Mapping[int, tuple[str, Body]],
) -> Iterator[Contact]:
    """Yield what PyBullet's points of one body tell."""
    for point in points:
        other_name, other = owners[point[2]]
        distance, force = point[8], point[9]
        # Bullet also reports points that are only near, up to 2 cm. They carry no force.
        if other_name == name or (distance > 0.0 and force <= 0.0):
            continue
        yield Contact(
            _full_name(frames, name, body, point[3], point[5]),
            _full_name(frames, other_name, other, point[4], point[6]),
            point[6],
            point[7],
            max(0.0, -distance),
            force,
        )


class _PartFrames:
    """Transforms from the world to the frames of parts. It asks PyBullet once for each part."""

    def __init__(self, client: int) -> None:
        self._client = client
        self._known: dict[tuple[int, int], Pose] = {}

    def into(self, body: Body, link: int) -> Pose:
        """Return the world's pose in a part's frame."""
        found = self._known.get((body.uid, link))
        if found is None:
            found = self._known[body.uid, link] = part_pose(self._client, body, link).inverse()
        return found


def _full_name(frames: _PartFrames, model: str, body: Body, link: int, position_m: Vector3) -> str:
    shapes = body.parts[link + 1].collisions if body.collision is None else (body.collision,)
    shape = shapes[0]
    if len(shapes) > 1:
        # PyBullet reports the part, but not the shape. Take the shape whose surface is nearest to the point.
        shape = nearest(shapes, frames.into(body, link).place(position_m))
    return f"{model}::{shape.link}::{shape.collision.name}"


def nearest(shapes: Sequence[PlacedCollision], point_m: Vector3) -> PlacedCollision:
    """Return the shape whose surface is nearest to a point (part frame); of several, the first.

    It skips a shape if its bounding sphere is farther away than another shape's surface.
    """
    best, least_m = shapes[0], math.inf
    for shape in shapes:
        if math.dist(point_m, shape.pose.position_m) - shape.reach_m > least_m:
            continue
        distance_m = abs(distance_to(shape, point_m))
        if distance_m < least_m:
            best, least_m = shape, distance_m
    return best


def distance_to(placed: PlacedCollision, point_m: Vector3) -> float:
    """Signed distance of a point (part frame) to a shape, negative inside; for a mesh to its bounding box."""
    x, y, z = placed.inverse.place(point_m)
    return _signed_distance(placed.collision.geometry, x, y, z)


def _signed_distance(geometry: Geometry, x: float, y: float, z: float) -> float:
    if isinstance(geometry, Sphere):
        return math.sqrt(x * x + y * y + z * z) - geometry.radius_m
    if isinstance(geometry, Cylinder):
        return _outside(math.hypot(x, y) - geometry.radius_m, abs(z) - 0.5 * geometry.length_m)
    if isinstance(geometry, Plane):
        nx, ny, nz = geometry.normal
        return nx * x + ny * y + nz * z
    if isinstance(geometry, Box):
        length, width, height = geometry.size_m
        return _outside(abs(x) - 0.5 * length, abs(y) - 0.5 * width, abs(z) - 0.5 * height)
    vertices = mesh_of(geometry).vertices
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    gaps = (abs(c - 0.5 * (a + b)) - 0.5 * (b - a) for c, a, b in zip((x, y, z), low, high))
    return _outside(*map(float, gaps))


def _outside(*gaps: float) -> float:
    """Signed distance to a product of intervals from the signed distance along each."""
    nearest = max(gaps)
    return math.hypot(*(gap for gap in gaps if gap > 0.0)) if nearest > 0.0 else nearest
