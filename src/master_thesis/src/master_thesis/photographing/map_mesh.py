"""The borders of an explored map as a mesh, on which a survey is planned."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from scipy.sparse import coo_matrix

from gridslam.volume.octree.files import read_octree
from inspection_tools.survey.surface.of_mesh import NOT_SURVEYED
from master_thesis.errors import ScenarioError

UNKNOWN, FREE, OCCUPIED = 0, 1, 2
NAMES = {OCCUPIED: "surface", UNKNOWN: NOT_SURVEYED}
"""What free voxels border on. The unknown closes the space, and is no surface to photograph."""
PASSES, SHRINK, SWELL = 10, 0.5, -0.53
"""Of Taubin's filter: how often, and its factors, of which the second outweighs the first."""


def mesh_of_map(path: Path) -> trimesh.Scene:
    """Return the borders of the free voxels of a .bt or .ot file in the map, m, smoothed, facing the air.

    Raises:
        MapError: the file cannot be read.
        ScenarioError: no voxel of it is free, or none is occupied.
    """
    voxels = read_octree(path)
    box = voxels.box()
    values = np.pad(voxels.values(box), 1, constant_values=np.nan).T  # x, y, z
    kinds = np.where(np.isnan(values), UNKNOWN, np.where(values > 0.0, OCCUPIED, FREE)).astype(np.int8)
    low_m = (np.asarray(box.low) - 1) * voxels.resolution_m
    corners, quads, of = borders(kinds)
    corners_m = smoothed(corners, quads) * voxels.resolution_m + low_m
    scene = trimesh.Scene()
    for kind, name in NAMES.items():
        mine = quads[of == kind]
        if len(mine):
            faces = np.concatenate((mine[:, [0, 1, 2]], mine[:, [0, 2, 3]]))
            mesh = trimesh.Trimesh(corners_m, faces, process=False)
            mesh.remove_unreferenced_vertices()
            scene.add_geometry(mesh, node_name=name)
    if NAMES[OCCUPIED] not in scene.graph.nodes_geometry:
        raise ScenarioError(
            f"{path}: no free voxel lies beside an occupied one, so there is no surface in it."
        )
    return scene


def borders(kinds: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the faces between free voxels and others, which face the free side.

    The border of the array (x, y, z) must not be free.

    Returns: corners (n, 3), in voxels; quads (m, 4) of their numbers; (m,) the kind behind each.
    """
    quads, of = [], []
    for axis in range(3):
        first, second = np.eye(3, dtype=np.int64)[[(axis + 1) % 3, (axis + 2) % 3]]
        for sign in (1, -1):
            behind = np.roll(kinds, -sign, axis)
            free = np.argwhere((kinds == FREE) & (behind != FREE))
            corner = free + (sign > 0) * np.eye(3, dtype=np.int64)[axis]
            around = (
                (0 * first, second, first + second, first)
                if sign > 0
                else (0 * first, first, first + second, second)
            )
            quads.append(corner[:, None] + np.array(around))
            of.append(behind[tuple(free.T)])
    places = np.concatenate(quads)
    x, y, z = places.reshape(-1, 3).T
    shape = tuple(size + 1 for size in kinds.shape)
    kept, number_of = np.unique(np.ravel_multi_index((x, y, z), shape), return_inverse=True)
    corners = np.column_stack(np.unravel_index(kept, shape))
    return corners.astype(float), number_of.reshape(-1, 4), np.concatenate(of)


def smoothed(corners: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Return the corners (n, 3) without the steps of the voxels: each moves by half a voxel at most.

    A wall across the voxels becomes even. By Taubin's filter ("A signal processing approach to fair surface
    design", 1995), which shrinks no shape that is larger than some voxels; the bound is Gibson's
    ("Constrained elastic surface nets", 1998).
    """
    edges = np.unique(np.sort(np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)]), axis=1), axis=0)
    ends = np.concatenate((edges, edges[:, ::-1]))
    count = len(corners)
    joined = coo_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count)).tocsr()
    degree = np.bincount(ends[:, 0], minlength=count)[:, None]
    moved = corners
    for factor in (SHRINK, SWELL) * PASSES:
        moved = moved + factor * (joined @ moved / degree - moved)
    return corners + np.clip(moved - corners, -0.5, 0.5)
