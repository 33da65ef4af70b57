"""The models and worlds of SDF."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

from simulation_tools.geometry import IDENTITY, Pose, Vector3
from simulation_tools.sdf.elements.script import Script
from simulation_tools.sdf.elements.sensors import Plugin, Sensor
from simulation_tools.sdf.elements.shapes import Collision, Visual

SensorKind = TypeVar("SensorKind", bound=Sensor)


@dataclass(frozen=True)
class Inertial:
    """Mass and inertia of a link. pose: of the centre of mass (inertia axes) in the link frame.

    moments_kg_m2: (ixx, iyy, izz, ixy, ixz, iyz) about the centre of mass.
    """

    mass_kg: float
    pose: Pose
    moments_kg_m2: tuple[float, float, float, float, float, float]


DEFAULT_INERTIAL = Inertial(1.0, IDENTITY, (1.0, 1.0, 1.0, 0.0, 0.0, 0.0))
"""SDF's, where a file says nothing."""


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
    the joint's frame. lower_rad, upper_rad: limits, infinite if there are none. damping: N m s/rad.
    friction: the joint does not turn below this torque, N m.
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
class Model:
    """A model. pose: in the world frame. source: the file (or name) it was read from.

    relative_to: while it is read, the frame that the pose is given in; empty: the usual one. nested: names
    and poses, in the model frame, of the models whose links it has taken over.

    warnings: one sentence per file that names what this package does not support in it. script: of an actor,
    which is static for the physics.
    """

    name: str
    pose: Pose
    static: bool
    links: tuple[Link, ...]
    joints: tuple[Joint, ...] = ()
    plugins: tuple[Plugin, ...] = ()
    source: str = ""
    warnings: tuple[str, ...] = ()
    script: Script | None = None
    relative_to: str = ""
    nested: tuple[tuple[str, Pose], ...] = ()

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

    def sensors(self, kind: type[SensorKind]) -> tuple[tuple[Link, SensorKind], ...]:
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
class World:
    """A world with its models in their places. gravity_m_s2 and wind_m_s: vectors in the world frame."""

    name: str
    models: tuple[Model, ...]
    gravity_m_s2: Vector3 = (0.0, 0.0, -9.8)
    wind_m_s: Vector3 = (0.0, 0.0, 0.0)
    plugins: tuple[Plugin, ...] = ()
    source: str = ""
    warnings: tuple[str, ...] = ()
