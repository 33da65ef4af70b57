"""What an SDF file says, as frozen dataclasses: checked, with every ``<include>`` and pose resolved.

Lengths in metres, angles in radians, masses in kilograms. Every pose is given in the frame that its class's
docstring names, whatever ``frame`` attribute the file used. Defaults are those of the SDF 1.6 specification.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Tuple, Union

from simulation_tools.geometry import IDENTITY, Pose, Vector3

Rgba = Tuple[float, float, float, float]


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
    """A triangle mesh file. path: absolute path of the resolved uri. scale: factors along x, y, z."""

    path: str
    uri: str
    scale: Vector3 = (1.0, 1.0, 1.0)


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


Geometry = Union[Box, Cylinder, Sphere, Plane, Mesh, Heightmap]


@dataclass(frozen=True)
class Inertial:
    """Mass and inertia of a link. pose: of the centre of mass (inertia axes) in the link frame.

    moments_kg_m2: (ixx, iyy, izz, ixy, ixz, iyz) about the centre of mass.
    """

    mass_kg: float
    pose: Pose
    moments_kg_m2: tuple[float, float, float, float, float, float]


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


@dataclass(frozen=True)
class Noise:
    """Gaussian noise."""

    mean: float = 0.0
    stddev: float = 0.0


NO_NOISE = Noise()


@dataclass(frozen=True)
class ScanAxis:
    """Beams of a lidar about one axis: samples from min_angle_rad to max_angle_rad, both included."""

    samples: int
    min_angle_rad: float
    max_angle_rad: float

    @property
    def increment_rad(self) -> float:
        """Angle between neighbouring beams; zero when there is only one."""
        return (self.max_angle_rad - self.min_angle_rad) / (self.samples - 1) if self.samples > 1 else 0.0


@dataclass(frozen=True)
class RaySensor:
    """A lidar (``ray`` or ``gpu_ray``). pose: in the link frame; beams lie in its x-y plane.

    range_resolution_m: ranges are rounded to it, 0: not at all. update_rate_hz: 0 means every step.
    """

    name: str
    pose: Pose
    update_rate_hz: float
    horizontal: ScanAxis
    vertical: ScanAxis
    range_min_m: float
    range_max_m: float
    range_resolution_m: float = 0.0
    noise: Noise = NO_NOISE
    plugins: tuple[Plugin, ...] = ()


@dataclass(frozen=True)
class ImuSensor:
    """An inertial measurement unit. pose: in the link frame. Noise about x, y, z in rad/s and m/s2."""

    name: str
    pose: Pose
    update_rate_hz: float
    gyroscope_noise: tuple[Noise, Noise, Noise] = (NO_NOISE,) * 3
    accelerometer_noise: tuple[Noise, Noise, Noise] = (NO_NOISE,) * 3
    plugins: tuple[Plugin, ...] = ()


@dataclass(frozen=True)
class CameraSensor:
    """A camera (depth: a depth camera). pose: in the link frame, looking along x with z up."""

    name: str
    pose: Pose
    update_rate_hz: float
    depth: bool
    width: int
    height: int
    horizontal_fov_rad: float
    near_m: float
    far_m: float
    noise: Noise = NO_NOISE
    plugins: tuple[Plugin, ...] = ()


@dataclass(frozen=True)
class AirPressureSensor:
    """A barometer. pose: in the link frame. Noise in pascal.

    reference_altitude_m: altitude of the world's origin.
    """

    name: str
    pose: Pose
    update_rate_hz: float
    reference_altitude_m: float = 0.0
    noise: Noise = NO_NOISE
    plugins: tuple[Plugin, ...] = ()


Sensor = Union[RaySensor, ImuSensor, CameraSensor, AirPressureSensor]


@dataclass(frozen=True)
class Plugin:
    """A ``<plugin>``, kept as it is for whoever knows its name.

    parameters: stripped text of each child element by its path (``"motorNumber"``, ``"control/kp"``).
    line: where it stands in the file, for messages.
    """

    name: str
    filename: str
    parameters: dict[str, str] = field(default_factory=dict)
    line: int = 0


@dataclass(frozen=True)
class Link:
    """A rigid body of a model. pose: in the model frame. gravity: whether it has weight."""

    name: str
    pose: Pose
    inertial: Inertial
    collisions: tuple[Collision, ...] = ()
    visuals: tuple[Visual, ...] = ()
    sensors: tuple[Sensor, ...] = ()
    gravity: bool = True


@dataclass(frozen=True)
class Joint:
    """A joint between two links of a model (parent may be ``"world"``).

    kind: ``"fixed"`` or ``"revolute"``. pose: of the joint in the child link's frame. axis: unit vector in
    the joint's frame. lower_rad, upper_rad: limits, infinite when there are none. damping: N m s/rad.
    friction: torque up to which the joint does not turn, N m.
    """

    name: str
    kind: str
    parent: str
    child: str
    pose: Pose = IDENTITY
    axis: Vector3 = (0.0, 0.0, 1.0)
    lower_rad: float = float("-inf")
    upper_rad: float = float("inf")
    damping: float = 0.0
    friction: float = 0.0


@dataclass(frozen=True)
class Light:
    """A light, for whoever draws. kind: point, directional or spot. pose: in the world (or model) frame."""

    name: str
    kind: str
    pose: Pose
    diffuse: Rgba = (1.0, 1.0, 1.0, 1.0)
    direction: Vector3 = (0.0, 0.0, -1.0)


@dataclass(frozen=True)
class Model:
    """A model. pose: in the world frame. source: the file (or name) it was read from.

    warnings: one sentence per file that names what this package does not support in it.
    """

    name: str
    pose: Pose
    static: bool
    links: tuple[Link, ...]
    joints: tuple[Joint, ...] = ()
    plugins: tuple[Plugin, ...] = ()
    source: str = ""
    warnings: tuple[str, ...] = ()

    def link(self, name: str) -> Link:
        """Return the link of that name; KeyError when there is none."""
        for link in self.links:
            if link.name == name:
                return link
        raise KeyError(name)

    def joint(self, name: str) -> Joint:
        """Return the joint of that name; KeyError when there is none."""
        for joint in self.joints:
            if joint.name == name:
                return joint
        raise KeyError(name)

    def sensors(self, kind: type) -> tuple[tuple[Link, Sensor], ...]:
        """Return every (link, sensor) of one kind, e.g. `RaySensor`, in the file's order."""
        return tuple(
            (link, sensor) for link in self.links for sensor in link.sensors if isinstance(sensor, kind)
        )

    def placed(self, name: str | None = None, pose: Pose | None = None) -> Model:
        """Return the same model under another name or at another pose."""
        return replace(
            self, name=self.name if name is None else name, pose=self.pose if pose is None else pose
        )


@dataclass(frozen=True)
class Physics:
    """What ``<physics>`` says about time: step in seconds, real-time factor (0: as fast as possible)."""

    max_step_size_s: float | None = None
    real_time_factor: float | None = None


UNSET_PHYSICS = Physics()


@dataclass(frozen=True)
class World:
    """A world with its models in their places. gravity_m_s2 and wind_m_s: vectors in the world frame."""

    name: str
    models: tuple[Model, ...]
    gravity_m_s2: Vector3 = (0.0, 0.0, -9.8)
    wind_m_s: Vector3 = (0.0, 0.0, 0.0)
    physics: Physics = UNSET_PHYSICS
    lights: tuple[Light, ...] = ()
    plugins: tuple[Plugin, ...] = ()
    source: str = ""
    warnings: tuple[str, ...] = ()
