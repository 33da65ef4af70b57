"""Triangles of mesh files and of SDF worlds, whose meshes `simulation_tools` writes: it alone reads SDF."""

from __future__ import annotations

import logging
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mesh_files.errors import MeshFileError
from mesh_files.reading import Part, read_parts
from mesh_files.scratch import scratch_folder

WORLD_SUFFIXES = (".world", ".sdf")
READING_S = 600.0
"""Wall time in which a world is read."""
_STEP = np.uint64(0x9E3779B97F4A7C15)
_MIXING = (
    (np.uint64(30), np.uint64(0xBF58476D1CE4E5B9)),
    (np.uint64(27), np.uint64(0x94D049BB133111EB)),
)
"""Constants of splitmix64 (Steele, Lea and Flood, 2014)."""
LEAST_M2 = 1e-12
"""Twice the area of a triangle that counts."""


def read_surfaces(path: Path) -> list[Part]:
    """Return the things of a mesh file or of an SDF world, as `read_parts` does.

    Raises:
        MeshFileError: the file cannot be used.
    """
    if not path.is_file():
        raise MeshFileError("there is no such file. Give a mesh or an SDF world")
    if path.suffix.lower() not in WORLD_SUFFIXES:
        return read_parts(path)
    with scratch_folder("mesh_files") as folder:
        return read_parts(_mesh_of_world(path, Path(folder) / "world.glb"))


def _mesh_of_world(world: Path, mesh: Path) -> Path:
    command = [sys.executable, "-m", "simulation_tools.world.mesh_file", str(world), str(mesh)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=READING_S)
    except subprocess.TimeoutExpired:
        raise MeshFileError(f"its surfaces were not read within {READING_S:g} s") from None
    if done.returncode:
        told = (done.stderr.strip().splitlines() or ["simulation_tools did not say why."])[-1]
        raise MeshFileError(f"its surfaces cannot be read. {told.rstrip('.')}")
    return mesh


class Triangles(NamedTuple):
    """corners_m: (m, 3, 3). names: of the things. part: (m,) index of each triangle's thing."""

    corners_m: np.ndarray
    names: tuple[str, ...]
    part: np.ndarray


def read_triangles(path: Path, most: int = 2_000_000) -> Triangles:
    """Return the triangles of a mesh file or of an SDF world that have finite corners and an area.

    A triangle that is there twice, facing the same way, counts once. A warning is logged if triangles without
    finite corners, or second ones, are left out.

    Raises:
        MeshFileError: the file cannot be used, or it has none, or more than `most`.
    """
    parts = read_surfaces(path)
    count = sum(len(each.triangles) for each in parts)
    if count > most:
        raise MeshFileError(
            f"has {count:,} triangles, more than the {most:,} that are worked with: "
            "simplify it, for example in MeshLab (Quadric Edge Collapse Decimation)"
        )
    corners_m = np.concatenate([each.vertices_m[each.triangles] for each in parts])
    part = np.repeat(np.arange(len(parts)), [len(each.triangles) for each in parts])
    across = np.cross(corners_m[:, 1] - corners_m[:, 0], corners_m[:, 2] - corners_m[:, 0])
    finite = np.isfinite(corners_m).all(axis=(1, 2))
    kept = finite & (np.linalg.norm(across, axis=1) > LEAST_M2)
    if not kept.any():
        raise MeshFileError("none of its triangles has finite corners and an area. Export it again")
    first = is_first(corners_m[kept])
    kept[kept] = first
    for lost, why in (
        (int((~finite).sum()), "which have a corner that is no finite number"),
        (int((~first).sum()), "which are there twice"),
    ):
        if lost:
            told = "%s: left out %d of %d triangles, %s."
            logging.getLogger(__name__).warning(told, path, lost, count, why)
    return Triangles(corners_m[kept], tuple(each.name for each in parts), part[kept])


def is_first(corners_m: np.ndarray) -> np.ndarray:
    """Return (m,): whether no triangle (m, 3, 3) before has the same corners in the same sense of rotation.

    Triangles are compared by sums of 64 bits, so two of two million differ wrongly with a chance of 1e-7.
    """
    bits = np.ascontiguousarray(corners_m + 0.0).view(np.uint64)  # + 0.0: a minus zero is a zero
    corner = np.zeros(bits.shape[:2], np.uint64)
    for axis in range(3):
        corner = _mixed(corner + bits[:, :, axis])
    whole = np.zeros(len(bits), np.uint64)
    for k in range(3):  # the sum is the same, whichever corner is the first
        a, b, c = (corner[:, (k + each) % 3] for each in range(3))
        whole += _mixed(_mixed(a + _mixed(b)) + c)
    found = np.zeros(len(corners_m), bool)
    found[np.unique(whole, return_index=True)[1]] = True
    return found


def _mixed(bits: np.ndarray) -> np.ndarray:
    """Return numbers of 64 bits that change in half of their bits if one bit changes (splitmix64)."""
    bits = bits + _STEP
    for shift, factor in _MIXING:
        bits = (bits ^ (bits >> shift)) * factor
    return bits ^ (bits >> np.uint64(31))
