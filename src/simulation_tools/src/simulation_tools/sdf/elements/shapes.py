"""The shapes of SDF: what touches, and what is drawn."""

from __future__ import annotations

import math
from dataclasses import dataclass

from simulation_tools.geometry import Pose, Vector3

Rgba = tuple[float, float, float, float]


@dataclass(frozen=True)
class Box:
    """A box centred on its pose; size_m: edge lengths along x, y, z."""

    size_m: Vector3


@dataclass(frozen=True)
class Cylinder:
    """A cylinder centred on its pose, its axis along z."""

    radius_m: float
    length_m: float


@dataclass(frozen=True)
class Sphere:
    """A sphere centred on its pose."""

    radius_m: float


@dataclass(frozen=True)
class Plane:
    """A plane through its pose; infinite for collisions, size_m for drawing. normal: unit vector."""

    normal: Vector3 = (0.0, 0.0, 1.0)
    size_m: tuple[float, float] = (1.0, 1.0)

    @property
    def turn_from_z(self) -> Pose:
        """Shortest turn that takes the z axis to the normal."""
        x, y, z = self.normal
        if z < -1.0 + 1e-12:
            return Pose(orientation_xyzw=(1.0, 0.0, 0.0, 0.0))
        length = math.sqrt(x * x + y * y + (1.0 + z) ** 2)  # of the quaternion (z axis) x normal, 1 + cos
        return Pose(orientation_xyzw=(-y / length, x / length, 0.0, (1.0 + z) / length))


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh file. path: absolute path of the resolved uri. scale: factors along x, y, z.

    A negative factor mirrors it. submesh: the part of the file that is meant, empty for all of it. centred:
    about the part's own middle.
    """

    path: str
    uri: str
    scale: Vector3 = (1.0, 1.0, 1.0)
    submesh: str = ""
    centred: bool = False


@dataclass(frozen=True)
class Heightmap:
    """A terrain drawn as a picture. path: absolute path of the resolved uri.

    size_m: along x and y, and height of the brightest pixel. position_m: of its middle, at height zero. The
    picture's top is at the greatest y.
    """

    path: str
    uri: str
    size_m: Vector3
    position_m: Vector3 = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Polyline:
    """Outlines in the xy plane, drawn from z = 0 up to height_m. An outline inside another one is a hole.

    outlines: of each its corners (x, y); the last one is joined to the first.
    """

    outlines: tuple[tuple[tuple[float, float], ...], ...]
    height_m: float


Geometry = Box | Cylinder | Sphere | Plane | Mesh | Heightmap | Polyline


@dataclass(frozen=True)
class Surface:
    """Contact parameters of a collision shape."""

    friction: float = 1.0
    restitution: float = 0.0


DEFAULT_SURFACE = Surface()


@dataclass(frozen=True)
class Collision:
    """A shape that touches. pose: in the link frame."""

    name: str
    pose: Pose
    geometry: Geometry
    surface: Surface = DEFAULT_SURFACE


@dataclass(frozen=True)
class Visual:
    """A shape that is drawn. pose: in the link frame."""

    name: str
    pose: Pose
    geometry: Geometry
    rgba: Rgba = (0.7, 0.7, 0.7, 1.0)
