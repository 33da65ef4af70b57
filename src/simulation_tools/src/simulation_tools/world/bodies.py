"""Rigid parts as PyBullet bodies.

PyBullet reports the pose of a body's *inertial* frame (centre of mass, principal axes); everything else here
speaks of the part's own frame, which for a base is the model frame. `Body` keeps the two apart.

What cannot move becomes one PyBullet body per collision shape, as plain (maximal coordinate) rigid bodies:
measured with 300 of them a step takes 17 us, against 60 us as multibodies; and a contact then names its shape
by itself.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Callable, Hashable, Sequence

import numpy as np

from simulation_tools.geometry import Pose, Vector3
from simulation_tools.sdf.elements import Box, Cylinder, Geometry, Mesh, Plane, Rgba, Sphere
from simulation_tools.world.assembly import Part, PlacedCollision, PlacedVisual
from simulation_tools.world.engine import WorldError, pybullet
from simulation_tools.world.meshes import PLANE_HALF_SIZE_M, TriangleMesh, joined, mesh_of

MAX_SHAPES_PER_PART = 16  # MAX_COMPOUND_COLLISION_SHAPES of PyBullet's command buffer


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


class BodyFactory:
    """Creates bodies in one PyBullet client. draw: give them visual shapes too (for the GUI)."""

    def __init__(self, client: int, draw: bool) -> None:
        self._client = client
        self._draw = draw
        self._mesh_folder: tempfile.TemporaryDirectory | None = None
        # PyBullet never gives a used collision shape back, so equal ones are shared.
        self._shapes: dict[Hashable, int] = {}

    def close(self) -> None:
        """Remove what was written for PyBullet to read."""
        if self._mesh_folder is not None:
            self._mesh_folder.cleanup()
            self._mesh_folder = None

    def create(self, assembly: tuple[Part, ...], pose: Pose) -> list[Body]:
        """Create the bodies of an assembly with the model frame at a pose (world frame)."""
        if len(assembly) == 1 and assembly[0].mass is None:
            return self._fixed_bodies(assembly[0], pose)
        return [self._moving_body(assembly, pose)]

    def forget(self) -> None:
        """Note that PyBullet has been emptied, collision shapes included."""
        self._shapes.clear()

    # -- what cannot move ------------------------------------------------------------------------------------
    def _fixed_bodies(self, part: Part, pose: Pose) -> list[Body]:
        bodies = []
        for placed in part.collisions:
            geometry = placed.collision.geometry
            shape = self._shared(geometry, partial(self._collision_shape, geometry))
            place = pose @ placed.pose
            uid = pybullet.createMultiBody(
                0.0,
                shape,
                -1,
                place.position_m,
                place.orientation_xyzw,
                useMaximalCoordinates=1,
                physicsClientId=self._client,
            )
            self._set_contact(uid, -1, [placed])
            sphere = _sphere_around(mesh_of(geometry))
            bodies.append(Body(uid, (part,), placed.pose, placed.pose.inverse(), (shape,), (sphere,), placed))
        if self._draw and part.visuals:
            shape = self._visual_shape(part.visuals)
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

    def _shared(self, key: Hashable, create: Callable[[], int]) -> int:
        if key not in self._shapes:
            self._shapes[key] = create()
        return self._shapes[key]

    def _collision_shape(self, geometry: Geometry) -> int:
        if isinstance(geometry, Mesh):
            return pybullet.createCollisionShape(
                pybullet.GEOM_MESH,
                fileName=self._mesh_file(geometry),
                flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
                physicsClientId=self._client,
            )
        return pybullet.createCollisionShape(**_primitive(geometry), physicsClientId=self._client)

    # -- what moves ------------------------------------------------------------------------------------------
    def _moving_body(self, parts: tuple[Part, ...], pose: Pose) -> Body:
        base, inner = parts[0], parts[1:]
        mass, inertial, _ = _inertia(base)
        shapes = [
            self._shared(
                tuple((item.collision.geometry, item.pose) for item in part.collisions),
                partial(self._compound_shape, part.collisions),
            )
            for part in parts
        ]
        visuals = [self._visual_shape(part.visuals) if self._draw else -1 for part in parts]
        # A part's frame hangs in its parent's, a base's is the model frame.
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
            linkJointAxis=[part.joint.axis for part in inner],
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

    def _set_dynamics(self, uid: int, index: int, part: Part) -> None:
        # Two commands: PyBullet sends everything that comes along with a damping to the base.
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
        # PyBullet brakes every new joint with a motor; a free joint has none.
        pybullet.setJointMotorControl2(
            uid, index, pybullet.VELOCITY_CONTROL, force=0.0, physicsClientId=self._client
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

    def _compound_shape(self, placed: Sequence[PlacedCollision]) -> int:
        if not placed:
            return -1
        if len(placed) > MAX_SHAPES_PER_PART:
            raise WorldError(
                f"A moving body can have {MAX_SHAPES_PER_PART} collision shapes, not {len(placed)}; "
                f"join some of those of the link {placed[0].link}."
            )
        for item in placed:
            if isinstance(item.collision.geometry, Plane):
                raise WorldError(
                    f"The plane {item.link}::{item.collision.name} must belong to a static model."
                )
        shapes = [self._compound_entry(item.collision.geometry) for item in placed]
        keys = ("shapeType", "radius", "halfExtents", "length", "fileName")
        columns = {key: [shape[key] for shape in shapes] for key in keys}
        return pybullet.createCollisionShapeArray(
            shapeTypes=columns["shapeType"],
            radii=columns["radius"],
            halfExtents=columns["halfExtents"],
            lengths=columns["length"],
            fileNames=columns["fileName"],
            meshScales=[(1.0, 1.0, 1.0)] * len(shapes),
            collisionFramePositions=[item.pose.position_m for item in placed],
            collisionFrameOrientations=[item.pose.orientation_xyzw for item in placed],
            physicsClientId=self._client,
        )

    def _compound_entry(self, geometry: Geometry) -> dict:
        entry = {"radius": 0.0, "halfExtents": (0.0, 0.0, 0.0), "length": 0.0, "fileName": ""}
        if isinstance(
            geometry, Mesh
        ):  # without the concave flag PyBullet takes the convex hull, as moving needs
            return {**entry, "shapeType": pybullet.GEOM_MESH, "fileName": self._mesh_file(geometry)}
        primitive = _primitive(geometry)
        if "height" in primitive:
            primitive["length"] = primitive.pop("height")
        return {**entry, **primitive}

    def _visual_shape(self, placed: Sequence[PlacedVisual]) -> int:
        """Create one shape of several, a mesh for each colour: PyBullet draws few pieces faster than many."""
        if not placed:
            return -1
        by_colour: dict[Rgba, list[TriangleMesh]] = {}
        for item in placed:
            colour = item.visual.rgba
            if colour not in by_colour and len(by_colour) == MAX_SHAPES_PER_PART:
                colour = next(iter(by_colour))
            by_colour.setdefault(colour, []).append(_drawn(item.visual.geometry).transformed(item.pose))
        count = len(by_colour)
        return pybullet.createVisualShapeArray(
            shapeTypes=[pybullet.GEOM_MESH] * count,
            fileNames=[self._write_obj(joined(meshes)) for meshes in by_colour.values()],
            meshScales=[(1.0, 1.0, 1.0)] * count,
            rgbaColors=list(by_colour),
            visualFramePositions=[(0.0, 0.0, 0.0)] * count,
            visualFrameOrientations=[(0.0, 0.0, 0.0, 1.0)] * count,
            physicsClientId=self._client,
        )

    # -- meshes ----------------------------------------------------------------------------------------------
    def _mesh_file(self, geometry: Mesh) -> str:
        # Always by way of an OBJ of our own: PyBullet's readers know fewer formats than trimesh.
        return self._write_obj(mesh_of(geometry))

    def _write_obj(self, mesh: TriangleMesh) -> str:
        if self._mesh_folder is None:
            self._mesh_folder = tempfile.TemporaryDirectory(prefix="simulation_tools_meshes_")
        folder = Path(self._mesh_folder.name)
        path = folder / f"{len(list(folder.iterdir()))}.obj"
        with path.open("w") as file:
            file.writelines(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in mesh.vertices.tolist())
            file.writelines(f"f {a} {b} {c}\n" for a, b, c in (mesh.triangles + 1).tolist())
        return str(path)


def part_mesh(part: Part) -> TriangleMesh | None:
    """Return the mesh of a part's collision shapes in the part's frame; None when it has none."""
    meshes = [mesh_of(item.collision.geometry).transformed(item.pose) for item in part.collisions]
    return joined(meshes) if meshes else None


def _sphere_around(mesh: TriangleMesh | None) -> tuple[Vector3, float]:
    return ((0.0, 0.0, 0.0), 0.0) if mesh is None else (tuple(mesh.centre_m.tolist()), mesh.radius_m)


def _drawn(geometry: Geometry) -> TriangleMesh:
    mesh = mesh_of(geometry)
    if isinstance(geometry, Plane):  # infinite to the touch, but drawn in its size
        return TriangleMesh(mesh.vertices * (0.5 * max(geometry.size_m) / PLANE_HALF_SIZE_M), mesh.triangles)
    return mesh


def _inertia(part: Part) -> tuple[float, Pose, Vector3]:
    """Return mass, inertial frame in the part's frame, and principal moments; zero for what cannot move."""
    if part.mass is None:
        return 0.0, Pose(), (0.0, 0.0, 0.0)
    frame, moments = part.mass.principal()
    return part.mass.mass_kg, frame, moments


def _primitive(geometry: Geometry) -> dict:
    if isinstance(geometry, Box):
        return {"shapeType": pybullet.GEOM_BOX, "halfExtents": [0.5 * edge for edge in geometry.size_m]}
    if isinstance(geometry, Cylinder):
        return {
            "shapeType": pybullet.GEOM_CYLINDER,
            "radius": geometry.radius_m,
            "height": geometry.length_m,
        }
    if isinstance(geometry, Sphere):
        return {"shapeType": pybullet.GEOM_SPHERE, "radius": geometry.radius_m}
    return {"shapeType": pybullet.GEOM_PLANE, "planeNormal": geometry.normal}
