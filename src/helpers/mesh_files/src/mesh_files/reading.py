"""Reads mesh files: STL, OBJ, PLY, glTF, COLLADA, 3MF and what else trimesh knows."""

from __future__ import annotations

import io
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Iterator, NamedTuple

import numpy as np

from mesh_files.axes import turn_of
from mesh_files.collada_text import plain_collada
from mesh_files.contents import check_content, text_of
from mesh_files.errors import MeshFileError
from mesh_files.gltf import check_gltf, gltf_document
from mesh_files.obj import plain_obj, with_points
from mesh_files.off import read_off
from mesh_files.ply import read_ply
from mesh_files.stl import is_text_stl, plain_stl, whole_stl
from mesh_files.three_mf import read_3mf

_ALONE = "geometry_0"
"""Name of the thing in a file that names none."""
_NO_CORNER = "a triangle has a corner that does not exist. Export it again"
_BESIDE = ("gltf",)
"""Kinds that name other files, without which they are not whole."""


class Part(NamedTuple):
    """A thing in a file. name: of its node. vertices_m: (n, 3), z up. triangles: (m, 3), of vertices."""

    name: str
    vertices_m: np.ndarray
    triangles: np.ndarray


def read_parts(path: Path, content: bytes | None = None, turns: bool = True) -> list[Part]:
    """Return the things of a mesh file, in metres and in one frame.

    COLLADA and 3MF tell their unit; others are in metres. content: in place of the file's. turns: the axis
    that the file calls up becomes z; otherwise the file's z is up, whatever it says.

    Raises:
        MeshFileError: it cannot be read, or it has no triangle.
    """
    kind = path.suffix[1:].lower()
    try:
        held = path.read_bytes() if content is None else content
    except OSError as error:
        raise MeshFileError(f"cannot be read: {error.strerror}") from None
    if not held:
        raise MeshFileError("is empty. Export it again")
    check_content(kind, held)
    if kind == "3mf":
        parts = [_checked(Part(*each)) for each in read_3mf(held) if len(each[2])]
    elif kind in ("off", "ply"):
        vertices, triangles = read_ply(held) if kind == "ply" else read_off(text_of(held))
        parts = [_checked(Part(_ALONE, vertices, triangles))] if len(triangles) else []
    else:
        scene = _scene(path, kind, held)
        turn = turn_of(kind, held) if turns else np.eye(3)
        parts = list(_parts(scene, _metres(scene.units) * turn))
    if not parts:
        raise MeshFileError("there is no surface in it. Export triangles, not lines or points")
    return parts


def _parts(scene: Any, turn: np.ndarray) -> Iterator[Part]:
    import trimesh

    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        mesh = scene.geometry[geometry]
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            vertices, triangles = np.asarray(mesh.vertices, float), np.asarray(mesh.faces)
            if vertices.shape[1:] != (3,):
                raise MeshFileError("has places that are not of three numbers. Export it again")
            placed = trimesh.transform_points(vertices, transform)
            if np.linalg.det(transform[:3, :3]) < 0.0:  # mirrored, so its triangles would face inside
                triangles = triangles[:, ::-1]
            yield _checked(Part(str(node), placed @ turn.T, triangles))


def _checked(part: Part) -> Part:
    """Return a thing whose triangles have corners that exist."""
    if part.triangles.min() < 0 or part.triangles.max() >= len(part.vertices_m):
        raise MeshFileError(_NO_CORNER)
    return part


def _metres(unit: str | None) -> float:
    """Return the length, m, of a file's unit."""
    import trimesh

    if unit is None:
        return 1.0
    try:
        return float(trimesh.units.unit_conversion(unit, "meters"))
    except (KeyError, ValueError, TypeError):
        raise MeshFileError(f'its unit is "{unit}", which is unknown. Export it in metres') from None


def _scene(path: Path, kind: str, content: bytes) -> Any:
    """Return trimesh's scene of a file."""
    import trimesh  # half a second to import, and most who import this module read no mesh

    given: Any = io.BytesIO(content)
    if kind == "stl" and is_text_stl(content):
        given, kind = io.StringIO(plain_stl(with_points(text_of(content)))), "stl_ascii"
    elif kind == "stl":
        given = io.BytesIO(whole_stl(content))
    elif kind in ("glb", "gltf"):
        check_gltf(gltf_document(kind, content))
        given = path if kind in _BESIDE else given
    elif kind == "dae":
        given = io.BytesIO(plain_collada(content))
    elif kind == "obj":  # trimesh would guess in which letters it is written
        given = io.BytesIO(plain_obj(text_of(content)).encode())
    try:
        with _quiet():
            return trimesh.load_scene(given, file_type=kind, process=False)
    except (ImportError, NotImplementedError):
        raise MeshFileError(
            f"is of a kind that is not read here ({path.suffix}). Export it as STL, OBJ or PLY"
        ) from None
    except FileNotFoundError as error:
        raise MeshFileError(f"names another file, {error}, which is not beside it") from None
    except IndexError:
        raise MeshFileError(_NO_CORNER) from None
    except Exception as error:  # trimesh's loaders raise whatever their formats' libraries raise
        name, told = type(error).__name__, str(error)
        raise MeshFileError(f"cannot be read as a mesh ({name}: {told.removeprefix(name + ': ')})") from None


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep trimesh from logging tracebacks, as of a picture that a COLLADA file names and nobody has."""
    import trimesh

    log = trimesh.util.log
    before, log.disabled = log.disabled, True
    try:
        yield
    finally:
        log.disabled = before
