"""Rigid parts as PyBullet bodies.

PyBullet reports the pose of a body's *inertial* frame (centre of mass, principal axes). Everything else here
uses the part's own frame, which for a base is the model frame. `Body` converts between the two.

A part that cannot move becomes one plain (maximal coordinate) PyBullet body per collision shape. With 300 of
them a step takes 17 us, against 60 us with multibodies (measured). In addition, a contact then identifies its
shape.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np

from simulation_tools.geometry import Pose, Vector3
from simulation_tools.world.assembly import Part, PlacedCollision
from simulation_tools.world.engine import WorldError, pybullet
from simulation_tools.world.shapes.bullet_shapes import ShapeFactory
from simulation_tools.world.shapes.meshes import drawn_mesh_of, mesh_of
from simulation_tools.world.shapes.triangle_mesh import TriangleMesh, joined


@dataclass(frozen=True)
class Body:
    """One PyBullet body. Its base (link index -1) is parts[0], its link k is parts[k + 1].

    to_inertial: pose of the base's inertial frame in the model frame, from_inertial its inverse. shapes:
    PyBullet's collision shape of each part, -1 for none; spheres: centre and radius of a sphere around each,
    in the same frame. collision: the only shape of a body that stands for one shape of something fixed; its
    frame is the shape's own.
    """

    uid: int
    parts: tuple[Part, ...]
    to_inertial: Pose
    from_inertial: Pose
    shapes: tuple[int, ...] = ()
    spheres: tuple[tuple[Vector3, float], ...] = ()
    collision: PlacedCollision | None = None

    @property
    def stands(self) -> bool:
        """Whether only a service call moves the body."""
        return self.collision is not None and not self.parts[0].scripted


class BodyFactory:
    """Creates bodies in one PyBullet client. draw: give them visual shapes too (for the GUI)."""

    def __init__(self, client: int, draw: bool) -> None:
        self._client = client
        self._draw = draw
        self.shapes = ShapeFactory(client)

    def create(self, name: str, model: list[tuple[Part, ...]], pose: Pose) -> list[list[Body]]:
        """Create the bodies of each of a model's assemblies, with the model frame at a pose (world frame).

        Raises WorldError, and then leaves no body behind.
        """
        built: list[list[Body]] = []
        try:
            for assembly in model:
                built.append(self._create(assembly, pose))
        except (WorldError, pybullet.error) as error:
            for body in (body for bodies in built for body in bodies):
                pybullet.removeBody(body.uid, physicsClientId=self._client)
            raise WorldError(f'The model "{name}" cannot be built: {str(error).rstrip(".")}.') from None
        return built

    def _create(self, assembly: tuple[Part, ...], pose: Pose) -> list[Body]:
        if len(assembly) == 1 and assembly[0].mass is None:
            return self._fixed_bodies(assembly[0], pose)
        return [self._moving_body(assembly, pose)]

    # -- fixed parts -----------------------------------------------------------------------------------------
    def _fixed_bodies(self, part: Part, pose: Pose) -> list[Body]:
        bodies = []
        unseen = self.shapes.unseen() if self._draw else -1
        for placed in part.collisions:
            geometry = placed.collision.geometry
            shape = self.shapes.standing(geometry)
            place = pose @ placed.pose
            uid = pybullet.createMultiBody(
                0.0,
                shape,
                unseen,
                place.position_m,
                place.orientation_xyzw,
                useMaximalCoordinates=1,
                physicsClientId=self._client,
            )
            self._set_contact(uid, -1, [placed])
            sphere = _sphere_around(mesh_of(geometry))
            bodies.append(Body(uid, (part,), placed.pose, placed.pose.inverse(), (shape,), (sphere,), placed))
        if self._draw and part.visuals:
            shape = self.shapes.visual(part.visuals)
            uid = pybullet.createMultiBody(
                0.0,
                -1,
                shape,
                pose.position_m,
                pose.orientation_xyzw,
                useMaximalCoordinates=1,
                physicsClientId=self._client,
            )
            bodies.append(Body(uid, (part,), Pose(), Pose()))
        return bodies

    # -- moving parts ----------------------------------------------------------------------------------------
    def _moving_body(self, parts: tuple[Part, ...], pose: Pose) -> Body:
        base, inner = parts[0], parts[1:]
        mass, inertial, _ = _inertia(base)
        shapes = [self.shapes.moving(part.collisions) for part in parts]
        visuals = [self._visual(part) for part in parts]
        # A part's frame is given in its parent's; a base's is the model frame.
        hinges = [parts[part.parent].pose.inverse() @ part.pose for part in inner]
        inertials = [_inertia(part)[1] for part in inner]
        uid = pybullet.createMultiBody(
            baseMass=mass,
            baseCollisionShapeIndex=shapes[0],
            baseVisualShapeIndex=visuals[0],
            basePosition=pose.position_m,
            baseOrientation=pose.orientation_xyzw,
            baseInertialFramePosition=inertial.position_m,
            baseInertialFrameOrientation=inertial.orientation_xyzw,
            linkMasses=[_inertia(part)[0] for part in inner],
            linkCollisionShapeIndices=shapes[1:],
            linkVisualShapeIndices=visuals[1:],
            linkPositions=[hinge.position_m for hinge in hinges],
            linkOrientations=[hinge.orientation_xyzw for hinge in hinges],
            linkInertialFramePositions=[frame.position_m for frame in inertials],
            linkInertialFrameOrientations=[frame.orientation_xyzw for frame in inertials],
            linkParentIndices=[part.parent for part in inner],
            linkJointTypes=[pybullet.JOINT_REVOLUTE] * len(inner),
            linkJointAxis=[part.joint.axis for part in inner if part.joint],
            physicsClientId=self._client,
        )
        if uid < 0:
            raise WorldError(
                "PyBullet refused to create a body; its command buffer may be too small for the model."
            )
        for index, part in enumerate(parts):
            self._set_dynamics(uid, index - 1, part)
        spheres = tuple(_sphere_around(part_mesh(part)) for part in parts)
        return Body(uid, parts, inertial, inertial.inverse(), tuple(shapes), spheres)

    def _visual(self, part: Part) -> int:
        if not self._draw:
            return -1
        return self.shapes.visual(part.visuals) if part.visuals else self.shapes.unseen()

    def _set_dynamics(self, uid: int, index: int, part: Part) -> None:
        # Two commands, because PyBullet applies everything in a command with a damping to the base.
        pybullet.changeDynamics(
            uid, index, localInertiaDiagonal=_inertia(part)[2], physicsClientId=self._client
        )
        if index < 0:
            pybullet.changeDynamics(
                uid, -1, linearDamping=0.0, angularDamping=0.0, physicsClientId=self._client
            )
        self._set_contact(uid, index, part.collisions)
        if part.joint is None:
            return
        lower, upper = part.joint.lower_rad, part.joint.upper_rad
        limits = (
            {"jointLowerLimit": lower, "jointUpperLimit": upper} if np.isfinite([lower, upper]).all() else {}
        )
        pybullet.changeDynamics(
            uid, index, jointDamping=part.joint.damping, physicsClientId=self._client, **limits
        )
        # PyBullet brakes every new joint with a motor. A motor with target speed zero is dry friction.
        pybullet.setJointMotorControl2(
            uid, index, pybullet.VELOCITY_CONTROL, force=part.joint.friction, physicsClientId=self._client
        )

    def _set_contact(self, uid: int, index: int, placed: Sequence[PlacedCollision]) -> None:
        surfaces = [item.collision.surface for item in placed]
        if surfaces:
            pybullet.changeDynamics(
                uid,
                index,
                lateralFriction=max(surface.friction for surface in surfaces),
                restitution=max(surface.restitution for surface in surfaces),
                spinningFriction=0.0,
                rollingFriction=0.0,
                physicsClientId=self._client,
            )


def part_mesh(part: Part) -> TriangleMesh | None:
    """Return the mesh of a part's collision shapes in the part's frame; None when it has none."""
    meshes = [mesh_of(item.collision.geometry).transformed(item.pose) for item in part.collisions]
    return joined(meshes) if meshes else None


def visual_mesh(part: Part) -> TriangleMesh | None:
    """Return the mesh of what is drawn of a part, in the part's frame; None when nothing is."""
    meshes = [drawn_mesh_of(item.visual.geometry).transformed(item.pose) for item in part.visuals]
    return joined(meshes) if meshes else None


def _sphere_around(mesh: TriangleMesh | None) -> tuple[Vector3, float]:
    return ((0.0, 0.0, 0.0), 0.0) if mesh is None else (tuple(mesh.centre_m.tolist()), mesh.radius_m)


def _inertia(part: Part) -> tuple[float, Pose, Vector3]:
    """Return mass, inertial frame in the part's frame, and principal moments; zero for a fixed part."""
    if part.mass is None:
        return 0.0, Pose(), (0.0, 0.0, 0.0)
    frame, moments = part.mass.principal()
    return part.mass.mass_kg, frame, moments
