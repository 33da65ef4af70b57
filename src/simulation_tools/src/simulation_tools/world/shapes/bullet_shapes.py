"""Geometry as PyBullet's collision and visual shapes."""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path
from typing import Callable, Hashable, Sequence

import numpy as np

from mesh_files.scratch import scratch_folder
from simulation_tools.geometry import IDENTITY, Pose
from simulation_tools.sdf.elements import (
    Box,
    Cylinder,
    Geometry,
    Heightmap,
    Mesh,
    Plane,
    Polyline,
    Rgba,
    Sphere,
)
from simulation_tools.world.assembly import PlacedCollision, PlacedVisual
from simulation_tools.world.engine import WorldError, pybullet
from simulation_tools.world.shapes.convex_parts import MAX_SLABS, convex_parts
from simulation_tools.world.shapes.extrusion import prisms
from simulation_tools.world.shapes.meshes import DRAWN_SAGITTA_M, GROUNDS, drawn_mesh_of, mesh_of
from simulation_tools.world.shapes.triangle_mesh import TriangleMesh, joined

MAX_SHAPES_PER_PART = 16  # MAX_COMPOUND_COLLISION_SHAPES of PyBullet's command buffer
_NO_SIZE = {"radius": 0.0, "halfExtents": (0.0, 0.0, 0.0), "length": 0.0, "fileName": ""}


class ShapeFactory:
    """Creates shapes in one PyBullet client; every method returns PyBullet's number for the shape.

    remarks: sentences on shapes that are not as their file has them.
    """

    def __init__(self, client: int) -> None:
        self._client = client
        self.remarks: list[str] = []
        self._mesh_folder: tempfile.TemporaryDirectory | None = None
        # PyBullet never frees a used collision shape, so equal shapes are shared.
        self._shapes: dict[Hashable, int] = {}

    def close(self) -> None:
        """Remove the files written for PyBullet."""
        if self._mesh_folder is not None:
            self._mesh_folder.cleanup()
            self._mesh_folder = None

    def forget(self) -> None:
        """Note that PyBullet has been emptied, collision shapes included."""
        self._shapes.clear()

    def standing(self, geometry: Geometry) -> int:
        """Return the collision shape of a fixed part. A mesh keeps its surface."""
        return self._shared(geometry, partial(self._standing, geometry))

    def moving(self, placed: Sequence[PlacedCollision]) -> int:
        """Return the collision shape of a moving part; -1: none. A mesh becomes its convex parts."""
        key = tuple((item.collision.geometry, item.pose) for item in placed)
        return self._shared(key, partial(self._compound, placed))

    def unseen(self) -> int:
        """Return an invisible shape for a body without visuals; else PyBullet draws its collision shape."""
        return self._shared("unseen", self._unseen)

    def visual(self, placed: Sequence[PlacedVisual]) -> int:
        """Return one visual shape for several, a mesh for each colour: few pieces draw faster than many."""
        if not placed:
            return -1
        by_colour: dict[Rgba, list[TriangleMesh]] = {}
        for item in placed:
            colour = item.visual.rgba
            if colour not in by_colour and len(by_colour) == MAX_SHAPES_PER_PART:
                colour = next(iter(by_colour))
            mesh = drawn_mesh_of(item.visual.geometry, DRAWN_SAGITTA_M)
            by_colour.setdefault(colour, []).append(mesh.transformed(item.pose))
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

    def _unseen(self) -> int:
        corners = 1e-6 * np.eye(3)
        return pybullet.createVisualShape(
            pybullet.GEOM_MESH,
            fileName=self._write_obj(TriangleMesh(corners, np.array(((0, 1, 2),)))),
            physicsClientId=self._client,
        )

    def _shared(self, key: Hashable, create: Callable[[], int]) -> int:
        if key not in self._shapes:
            self._shapes[key] = create()
        return self._shapes[key]

    def _standing(self, geometry: Geometry) -> int:
        if isinstance(geometry, (Mesh, Heightmap, Polyline)):
            return pybullet.createCollisionShape(
                pybullet.GEOM_MESH,
                fileName=self._mesh_file(geometry),
                flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
                physicsClientId=self._client,
            )
        return pybullet.createCollisionShape(**_primitive(geometry), physicsClientId=self._client)

    def _compound(self, placed: Sequence[PlacedCollision]) -> int:
        if not placed:
            return -1
        for item in placed:
            if isinstance(item.collision.geometry, GROUNDS):
                raise WorldError(
                    f"The ground {item.link}::{item.collision.name} must belong to a static model."
                )
        shapes = self._entries(placed)
        keys = ("shapeType", "radius", "halfExtents", "length", "fileName")
        columns = {key: [shape[key] for shape, _ in shapes] for key in keys}
        return pybullet.createCollisionShapeArray(
            shapeTypes=columns["shapeType"],
            radii=columns["radius"],
            halfExtents=columns["halfExtents"],
            lengths=columns["length"],
            fileNames=columns["fileName"],
            meshScales=[(1.0, 1.0, 1.0)] * len(shapes),
            collisionFramePositions=[pose.position_m for _, pose in shapes],
            collisionFrameOrientations=[pose.orientation_xyzw for _, pose in shapes],
            physicsClientId=self._client,
        )

    def _entries(self, placed: Sequence[PlacedCollision]) -> list[tuple[dict, Pose]]:
        """Return the entries of a part's shapes, and their places in it.

        PyBullet takes few entries, but an entry of a file may hold any number of shapes.
        """
        count = len(placed) if len(placed) <= MAX_SHAPES_PER_PART else MAX_SHAPES_PER_PART - 1
        entries, slabs_left = [], MAX_SLABS
        for item in placed[:count]:
            geometry = item.collision.geometry
            if isinstance(geometry, (Mesh, Polyline)):
                parts = self._parts_of(geometry, slabs_left)
                slabs_left -= len(parts)
                entries.append((self._hulls_entry(parts), item.pose))
            else:
                entries.append((_primitive_entry(geometry), item.pose))
        together: list[np.ndarray] = []
        for item in placed[count:]:
            parts = self._parts_of(item.collision.geometry, slabs_left)
            slabs_left -= len(parts)
            together += [item.pose.transform(corners) for corners in parts]
        return [*entries, (self._hulls_entry(together), IDENTITY)] if together else entries

    def _parts_of(self, geometry: Geometry, max_slabs: int) -> list[np.ndarray]:
        """Return the corners (n, 3) of a shape's convex parts."""
        if isinstance(geometry, Polyline):
            return prisms(geometry)
        parts, is_filled = convex_parts(mesh_of(geometry), max_slabs)
        if is_filled and isinstance(geometry, Mesh):
            self.remarks.append(
                f"{geometry.path}: The mesh belongs to a model that moves, and has too many triangles to "
                "stay open there. Bodies meet the convex hull of each of its pieces; lidars see the mesh."
            )
        return parts

    def _hulls_entry(self, parts: Sequence[np.ndarray]) -> dict:
        """Return the entry of convex parts. PyBullet takes the hull of each object of a file."""
        return {**_NO_SIZE, "shapeType": pybullet.GEOM_MESH, "fileName": self._write_hulls(parts)}

    def _mesh_file(self, geometry: Geometry) -> str:
        # Always write an OBJ file, because PyBullet reads fewer formats than trimesh.
        return self._write_obj(mesh_of(geometry))

    def _write_obj(self, mesh: TriangleMesh) -> str:
        path = self._new_file()
        with path.open("w") as file:
            file.writelines(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in mesh.vertices.tolist())
            file.writelines(f"f {a} {b} {c}\n" for a, b, c in (mesh.triangles + 1).tolist())
        return str(path)

    def _write_hulls(self, parts: Sequence[np.ndarray]) -> str:
        """Write the corners of each part as an object. Its faces only have to name every corner."""
        path, first = self._new_file(), 1
        with path.open("w") as file:
            for number, corners in enumerate(parts):
                file.write(f"o {number}\n")
                file.writelines(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in corners.tolist())
                last = first + len(corners) - 1
                names = [*range(first, last + 1), last, last][: max(3, -(-len(corners) // 3) * 3)]
                file.writelines(f"f {a} {b} {c}\n" for a, b, c in zip(names[::3], names[1::3], names[2::3]))
                first = last + 1
        return str(path)

    def _new_file(self) -> Path:
        if self._mesh_folder is None:
            self._mesh_folder = scratch_folder("simulation_tools_meshes")
        folder = Path(self._mesh_folder.name)
        return folder / f"{len(list(folder.iterdir()))}.obj"


def _primitive_entry(geometry: Geometry) -> dict:
    primitive = _primitive(geometry)
    if "height" in primitive:
        primitive["length"] = primitive.pop("height")
    return {**_NO_SIZE, **primitive}


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
    if isinstance(geometry, Plane):
        return {"shapeType": pybullet.GEOM_PLANE, "planeNormal": geometry.normal}
    raise WorldError(f"A {type(geometry).__name__.lower()} is not a simple shape of PyBullet.")
