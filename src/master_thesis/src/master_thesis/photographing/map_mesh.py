"""The borders of an explored map as a mesh, on which a survey is planned."""

from __future__ import annotations

from pathlib import Path
from typing import Iterator

import numpy as np
import trimesh

from gridslam.volume.octree.files import read_octree
from inspection_tools.survey.surface.of_mesh import NOT_SURVEYED
from master_thesis.errors import ScenarioError

UNKNOWN, FREE, OCCUPIED = 0, 1, 2
NAMES = {OCCUPIED: "surface", UNKNOWN: NOT_SURVEYED}
"""What free voxels border on. The unknown closes the space, and is no surface to photograph."""


def mesh_of_map(path: Path) -> trimesh.Scene:
    """Return the borders of the free voxels of a .bt or .ot file, in the map, m, facing the free side.

    Raises:
        MapError: the file cannot be read.
        ScenarioError: no voxel of it is free, or none is occupied.
    """
    voxels = read_octree(path)
    box = voxels.box()
    values = np.pad(voxels.values(box), 1, constant_values=np.nan).T  # x, y, z
    kinds = np.where(np.isnan(values), UNKNOWN, np.where(values > 0.0, OCCUPIED, FREE)).astype(np.int8)
    low_m = (np.asarray(box.low) - 1) * voxels.resolution_m
    scene = trimesh.Scene()
    for kind, name in NAMES.items():
        quads = np.concatenate(list(borders(kinds, kind)))
        if len(quads):
            corners = (quads.reshape(-1, 3) * voxels.resolution_m + low_m).astype(float)
            first = 4 * np.arange(len(quads))[:, None]
            faces = np.concatenate((first + np.array((0, 1, 2)), first + np.array((0, 2, 3))))
            scene.add_geometry(trimesh.Trimesh(corners, faces, process=False), node_name=name)
    if NAMES[OCCUPIED] not in scene.graph.nodes_geometry:
        raise ScenarioError(
            f"{path}: no free voxel lies beside an occupied one, so there is no surface in it."
        )
    return scene


def borders(kinds: np.ndarray, kind: int) -> Iterator[np.ndarray]:
    """Yield quads (n, 4, 3), in voxels, between free voxels and those of a kind (x, y, z), merged in rows.

    The border of the array must be unknown.
    """
    free = kinds == FREE
    for axis in range(3):
        along = 0 if axis else 1
        aside = 3 - axis - along
        for sign in (1, -1):
            wall = free & (np.roll(kinds, -sign, axis) == kind)
            rows = np.moveaxis(wall, along, 2).astype(np.int8)
            changes = np.diff(rows, axis=2, prepend=0, append=0)
            begins, ends = np.argwhere(changes > 0), np.argwhere(changes < 0)[:, 2]
            corner = np.empty((len(begins), 3))
            others = [each for each in range(3) if each != along]
            corner[:, others], corner[:, along] = begins[:, :2], begins[:, 2]
            corner[:, axis] += sign > 0
            length = (ends - begins[:, 2])[:, None] * np.eye(3)[along]
            width = np.broadcast_to(np.eye(3)[aside], length.shape)
            towards = -sign * np.eye(3)[axis]
            if np.cross(np.eye(3)[along], np.eye(3)[aside]) @ towards < 0:
                length, width = width, length
            yield np.stack((corner, corner + length, corner + length + width, corner + width), axis=1)
