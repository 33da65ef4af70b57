"""Reads mesh files (STL, OBJ, COLLADA): whole, or one submesh as Gazebo names it."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
from lxml import etree

from mesh_files.errors import MeshFileError
from mesh_files.reading import read_parts
from simulation_tools.world.shapes.terrain import MeshError
from simulation_tools.world.shapes.triangle_mesh import TriangleMesh

MAX_TRIANGLES = 2_000_000
_INSTANCES = ("instance_geometry", "instance_controller")


@lru_cache(maxsize=64)
def read_mesh(path: str, submesh: str = "", centred: bool = False) -> TriangleMesh:
    """Return the triangles of a file in metres. Raises MeshError.

    submesh: name of the node of a COLLADA file, or of the object or group of an OBJ file, whose triangles
    are taken; empty for all. centred: with the middle of their bounding box in the origin.
    """
    vertices, triangles = _triangles(path, submesh)
    if not len(triangles) or len(triangles) > MAX_TRIANGLES:
        raise MeshError(
            f"{path}: The mesh holds {len(triangles)} triangles; 1 to {MAX_TRIANGLES} are allowed."
        )
    if not np.isfinite(vertices).all() or triangles.min() < 0 or triangles.max() >= len(vertices):
        raise MeshError(f"{path}: The mesh holds vertices that are not finite or do not exist.")
    if submesh or centred:  # a submesh's file may hold vertices of the others
        used, triangles = np.unique(triangles, return_inverse=True)
        vertices, triangles = vertices[used], triangles.reshape(-1, 3).astype(np.int32)
    if centred:
        vertices = vertices - 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    return TriangleMesh(vertices, triangles)


def _triangles(path: str, submesh: str) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 3), m, and triangles (m, 3). Its <up_axis> is ignored, as in Gazebo."""
    kind = Path(path).suffix.lower()
    try:
        content = _PART_OF[kind](path, submesh) if submesh and kind in _PART_OF else None
        parts = read_parts(Path(path), content, turns=False)
    except MeshFileError as error:
        raise MeshError(f"{path}: The mesh cannot be used: {error}.") from None
    except (OSError, etree.LxmlError) as error:
        raise MeshError(f"{path}: The mesh cannot be read: {error}.") from None
    starts = np.cumsum([0] + [len(each.vertices_m) for each in parts])
    vertices = np.concatenate([each.vertices_m for each in parts])
    triangles = np.concatenate([each.triangles + start for each, start in zip(parts, starts)])
    return vertices, triangles.astype(np.int32)


def _part_of_collada(path: str, submesh: str) -> bytes:
    """Return a COLLADA file in which only one submesh is placed.

    As in Gazebo, a submesh has the name of the node that places it, or of the nearest node above with a name.
    """
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=True)
    tree = etree.parse(path, parser)
    found = False
    for element in [each for each in tree.iter(etree.Element) if _local_name(each) in _INSTANCES]:
        names = (node.get("name") for node in element.iterancestors() if _local_name(node) == "node")
        if next((name for name in names if name), "") == submesh:
            found = True
        else:
            element.getparent().remove(element)
    if not found:
        raise _no_submesh(path, submesh)
    return etree.tostring(tree)


def _part_of_obj(path: str, submesh: str) -> bytes:
    """Return an OBJ file with the faces of one object or group only."""
    kept, current, found = [], "", False
    for line in Path(path).read_text(encoding="utf-8", errors="replace").splitlines():
        key, _, rest = line.strip().partition(" ")
        if key in ("o", "g"):
            current = rest.strip()
        elif key != "f" or current == submesh:
            kept.append(line)
            found |= key == "f"
    if not found:
        raise _no_submesh(path, submesh)
    return "\n".join(kept).encode()


def _no_submesh(path: str, submesh: str) -> MeshError:
    return MeshError(f'{path}: The file has no submesh "{submesh}".')


def _local_name(element: etree._Element) -> str:
    return etree.QName(element).localname


_PART_OF = {".dae": _part_of_collada, ".obj": _part_of_obj}
"""Readers of one submesh by the file's ending. An STL file is one submesh, whatever it is called."""
