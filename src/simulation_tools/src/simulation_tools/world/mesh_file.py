"""Writes the shapes of a world into a mesh file, one object for each model.

python -m simulation_tools.world.mesh_file WORLD.sdf MESH.glb (or .stl, .ply, .obj)
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
import trimesh

from simulation_tools.errors import SimulationToolsError
from simulation_tools.sdf.elements import Geometry, Model, Plane
from simulation_tools.sdf.parser import load_world
from simulation_tools.world.shapes.meshes import mesh_of, readable
from simulation_tools.world.shapes.triangle_mesh import TriangleMesh, joined

GROUND_M, TILE_M = 400.0, 5.0
"""A plane has no end; a mesh has. It consists of tiles, so that a reader can take those near the rest."""


def write_world_mesh(world_file: Path | str, mesh_file: Path) -> list[str]:
    """Write the collision shapes of a world, in its frame, in metres. Return the names of the models.

    Raises:
        SimulationToolsError: the world cannot be read.
        ValueError: trimesh does not know the mesh file's ending.
        OSError: the mesh file cannot be written.
    """
    meshes = {model.name: mesh for model in load_world(str(world_file)).models if (mesh := _mesh(model))}
    scene = trimesh.Scene()
    for name, mesh in meshes.items():
        middle_m = np.rint(mesh.centre_m)  # GLB has float32, which tells places 100 km away to 8 mm only
        solid = trimesh.Trimesh(mesh.vertices - middle_m, mesh.triangles, process=False)
        moved = trimesh.transformations.translation_matrix(middle_m)
        scene.add_geometry(solid, node_name=name, geom_name=name, transform=moved)
    scene.export(str(mesh_file))
    return list(meshes)


def _mesh(model: Model) -> TriangleMesh | None:
    usable, _ = readable(model)
    placed = [
        _shape(each.geometry).transformed(model.pose @ link.pose @ each.pose)
        for link in usable.links
        for each in link.collisions
    ]
    return joined(placed) if placed else None


def _shape(geometry: Geometry) -> TriangleMesh:
    return _tiles(geometry) if isinstance(geometry, Plane) else mesh_of(geometry)


def _tiles(plane: Plane) -> TriangleMesh:
    number = round(GROUND_M / TILE_M)
    lines = TILE_M * (np.arange(number + 1) - number / 2)
    x, y = (each.ravel() for each in np.meshgrid(lines, lines, indexing="ij"))
    corners = np.arange((number + 1) ** 2).reshape(number + 1, -1)
    low, right = corners[:-1, :-1].ravel(), corners[1:, :-1].ravel()
    far, left = corners[1:, 1:].ravel(), corners[:-1, 1:].ravel()
    triangles = np.concatenate([np.column_stack(each) for each in ((low, right, far), (low, far, left))])
    vertices = plane.turn_from_z.transform(np.column_stack((x, y, np.zeros_like(x))))
    return TriangleMesh(vertices, triangles.astype(np.int32))


def main() -> int:
    """Run the command. Return the exit code: 0, or 1 with one sentence on stderr."""
    parser = argparse.ArgumentParser(description="Write the shapes of an SDF world into a mesh file.")
    parser.add_argument("world", type=Path, help="SDF file")
    parser.add_argument("mesh", type=Path, help="file to write: .glb, .stl, .ply or .obj")
    given = parser.parse_args()
    try:
        print(f"{given.mesh}: {', '.join(write_world_mesh(given.world, given.mesh))}")
    except (SimulationToolsError, ValueError, OSError) as error:
        print(f"world_mesh: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
