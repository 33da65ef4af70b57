"""Reads a mesh or an SDF world as triangles with the names of the things that they belong to."""

from __future__ import annotations

import io
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator

import numpy as np
import trimesh

from inspection_tools.errors import SurveyError
from inspection_tools.survey.surface.stl_file import is_text_stl, stl_triangles, whole_stl

_LOG = trimesh.util.log
WORLD_SUFFIXES = (".world", ".sdf")
MOST_TRIANGLES = 2_000_000
END_OF_TEXT = 1000
"""The last characters of an STL of the text form, among which is its end."""
ENDLESS_M = 300.0
"""A thing this long is the ground of a world; it does not say how large the room is."""
READING_S = 600.0
"""Wall time in which a world is read."""
NOT_SURVEYED = "unknown"
"""Name of a thing that bounds the air and is no surface: what an explored map does not know."""
MAPPED_PLATING, MAPPED_STRUCTURE, MAPPED_BARS = "mapped_plating", "mapped_structure", "mapped_bars"
"""Names of things of sheets that each show their front only: what an explored map knows. Plating is wide, and
between bars one sees through, as between the rungs of a ladder.
"""


def is_mapped(name: str) -> bool:
    """Return whether a thing of this name is what an explored map knows."""
    return name.startswith("mapped")


@dataclass(frozen=True)
class Mesh:
    """triangles_m: (m, 3, 3) corners, map's frame. names: of the things. part: (m,) index of the name."""

    triangles_m: np.ndarray
    names: tuple[str, ...]
    part: np.ndarray

    @property
    def joined(self) -> np.ndarray:
        """(m,) as part, but all that an explored map knows is one thing: its plating ends at no edge."""
        known = np.array([is_mapped(name) for name in self.names])
        return np.where(known[self.part], int(known.argmax()), self.part)

    @property
    def area_m2(self) -> float:
        """Of all faces, each counted once."""
        across = np.cross(*np.moveaxis(self.triangles_m[:, 1:] - self.triangles_m[:, :1], 1, 0))
        return float(0.5 * np.linalg.norm(across, axis=1).sum())

    def bounds_m(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the corners of the box around all but endless ground."""
        kept = np.zeros(len(self.triangles_m), bool)
        for number in range(len(self.names)):
            own = self.part == number
            corners = self.triangles_m[own].reshape(-1, 3)
            kept[own] = np.ptp(corners, axis=0).max() < ENDLESS_M
        corners = self.triangles_m[kept if kept.any() else slice(None)].reshape(-1, 3)
        return corners.min(axis=0), corners.max(axis=0)


def read_mesh(path: Path) -> Mesh:
    """Read an SDF world, or a mesh that trimesh knows (STL, OBJ, PLY, GLB, DAE). z is up.

    COLLADA and 3MF tell their unit; others are in metres.

    Raises:
        SurveyError: the file cannot be read, has no surface, or too many triangles.
    """
    if not path.is_file():
        raise SurveyError(f"{path}: there is no such file. Give a mesh or an SDF world.")
    if path.suffix.lower() in WORLD_SUFFIXES:
        with tempfile.TemporaryDirectory() as folder:
            return _load(_mesh_of_world(path, Path(folder) / "world.glb"), path)
    if path.suffix.lower() == ".stl":
        return _mesh_of(path, _stl(path))
    return _load(path, path)


def _stl(path: Path) -> Any:
    """Return the scene of an STL."""
    if not is_text_stl(path):
        _refuse_many(stl_triangles(path), path)
        return _scene(path, io.BytesIO(whole_stl(path)), "stl")
    text = path.read_bytes().decode("utf-8", errors="replace")
    if "endsolid" not in text[-END_OF_TEXT:].lower():
        raise SurveyError(f"{path}: the STL is cut: it has no endsolid. Export it again.")
    return _scene(path, io.StringIO(text), "stl_ascii")


def _refuse_many(count: int, path: Path) -> None:
    if count > MOST_TRIANGLES:
        raise SurveyError(
            f"{path} has {count:,} triangles, more than the {MOST_TRIANGLES:,} that a survey is planned on: "
            "simplify it, for example in MeshLab (Quadric Edge Collapse Decimation)."
        )


def _mesh_of_world(world: Path, mesh: Path) -> Path:
    """Let `simulation_tools` write the mesh of a world: it alone reads SDF."""
    command = [sys.executable, "-m", "simulation_tools.world.mesh_file", str(world), str(mesh)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=READING_S)
    except subprocess.TimeoutExpired:
        raise SurveyError(f"{world}: its surfaces were not read within {READING_S:g} s.") from None
    if done.returncode:
        told = (done.stderr.strip().splitlines() or ["simulation_tools did not say why."])[-1]
        raise SurveyError(f"{world}: its surfaces cannot be read. {told}")
    return mesh


def _load(path: Path, told: Path) -> Mesh:
    return _mesh_of(told, _scene(told, path))


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep trimesh from logging tracebacks, as of a picture that a COLLADA file names and nobody has."""
    before, _LOG.disabled = _LOG.disabled, True
    try:
        yield
    finally:
        _LOG.disabled = before


def _scene(told: Path, given: Any, form: str | None = None) -> Any:
    try:
        with _quiet():
            return trimesh.load_scene(given, file_type=form)
    except ImportError:  # trimesh would guess in which letters a text is written; numbers are the same in all
        if not isinstance(given, Path):
            raise SurveyError(f"{told}: is no mesh of the form that its name tells.") from None
        text = given.read_bytes().decode("utf-8", errors="replace")
        return _scene(told, io.BytesIO(text.encode()), given.suffix[1:].lower())
    except Exception as error:  # trimesh's loaders raise whatever their formats' libraries raise
        raise SurveyError(f"{told}: cannot be read as a mesh ({type(error).__name__}: {error}).") from None


def _metres(told: Path, unit: str | None) -> float:
    """Return the length, m, of a file's unit; COLLADA and 3MF tell theirs, others are in metres."""
    if unit is None:
        return 1.0
    try:
        return float(trimesh.units.unit_conversion(unit, "meters"))
    except (KeyError, ValueError, TypeError):
        raise SurveyError(f'{told}: its unit is "{unit}", which is unknown. Export it in metres.') from None


def _mesh_of(told: Path, scene: Any) -> Mesh:
    names: list[str] = []
    triangles, part = [], []
    metres = _metres(told, scene.units)
    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        mesh = scene.geometry[geometry]
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            corners = trimesh.transform_points(mesh.vertices, transform)[mesh.faces]
            part.append(np.full(len(corners), len(names)))
            triangles.append(corners * metres)
            names.append(str(node))
    if not triangles:
        raise SurveyError(f"{told}: there is no surface in it.")
    corners, parts = np.concatenate(triangles), np.concatenate(part)
    _refuse_many(len(corners), told)
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    kept = np.isfinite(corners).all(axis=(1, 2)) & (areas > 1e-12)
    if not kept.any():
        raise SurveyError(f"{told}: none of its triangles has finite corners and an area.")
    return Mesh(corners[kept], tuple(names), parts[kept])
