"""The borders of an explored map as a mesh, on which a survey is planned."""

from __future__ import annotations

from pathlib import Path
from typing import Mapping, Sequence

import numpy as np
import trimesh
from scipy.sparse import coo_matrix

from flights.errors import ScenarioError
from flights.photographing.bars import are_bars, beams_on, cubes_of
from flights.photographing.plate_mesh import Kinds, beside, not_of, standing, with_backs
from flights.photographing.plating import is_plating
from gridslam.volume import CloudNode
from gridslam.volume.octree.files import read_octree
from gridslam.volume.plates import Plates, SeenPoints, plates_of, points_of
from gridslam.volume.saved.saved_map import read_volume
from inspection.survey.surface.mesh_file import (
    MAPPED_BARS,
    MAPPED_PLATING,
    MAPPED_STRUCTURE,
    NOT_SURVEYED,
)

UNKNOWN, FREE, OCCUPIED = 0, 1, 2
STATE_SUFFIX = ".state"
"""Of the file beside a map that has its clouds: what slam_octomap's ~save_state writes."""
SEED = 1
"""Of the planes that are tried: one map gives one mesh."""
PASSES, SHRINK, SWELL = 10, 0.5, -0.53
"""Of Taubin's filter: how often, and its factors, of which the second outweighs the first."""


def mesh_of_map(path: Path) -> trimesh.Scene:
    """Return the surface of a .bt or .ot file in the map, m, facing the air, and where the unknown begins.

    Where the file NAME.state beside it has the clouds of the map, the surface consists of plates that are
    fitted to their points. Elsewhere it is the smoothed border of the free voxels.

    Raises:
        MapError: the file cannot be read. StateError: the clouds cannot.
        ScenarioError: no voxel of it is free, or none is occupied.
    """
    state = path.with_suffix(STATE_SUFFIX)
    nodes = read_volume(state).corrected.nodes if state.is_file() else ()
    return scene_of(surfaces_of_map(path, nodes))


def surfaces_of_map(path: Path, nodes: Sequence[CloudNode]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return corners (n, 3), m, and quads (m, 4) of plating, structure, bars and the unknown, by their names.

    Bars are cubes: a plate would close what one sees through. The unknown closes the space, and is no surface
    to photograph.

    nodes: with the clouds of the map, or none. Raises: as `mesh_of_map`.
    """
    voxels = read_octree(path)
    box = voxels.box()
    values = np.pad(voxels.values(box), 1, constant_values=np.nan).T  # x, y, z
    kinds = np.where(np.isnan(values), UNKNOWN, np.where(values > 0.0, OCCUPIED, FREE)).astype(np.int8)
    side_m = voxels.resolution_m
    low_m = (np.asarray(box.low) - 1) * side_m
    corners, quads, of = borders(kinds)
    if not (of == OCCUPIED).any():
        raise ScenarioError(
            f"{path}: no free voxel lies beside an occupied one, so there is no surface in it."
        )
    corners_m = smoothed(corners, quads) * side_m + low_m
    whole_m, known_quads = corners_m, quads[of == OCCUPIED]
    bars = np.zeros((0, 3)), np.zeros((0, 4), np.int64)
    if nodes:
        points = points_of(nodes)
        closed, seen_through = _plates(points, nodes, Kinds(kinds, low_m, side_m))
        faces_m = corners[known_quads] * side_m + low_m
        left = not_of(closed, faces_m, side_m)
        of_bars = left & beside(seen_through, faces_m, side_m)
        if of_bars.any():
            bars = cubes_of(faces_m[of_bars], side_m, low_m, points.places_m)
        known_quads = known_quads[left & ~of_bars]
        whole_m = np.concatenate((corners_m, closed.corners_m.reshape(-1, 3)))
        own = np.arange(len(corners_m), len(whole_m)).reshape(-1, 4)
        known_quads = np.concatenate((known_quads, own))
    wide = is_plating(whole_m, known_quads)
    surfaces = {
        MAPPED_PLATING: (whole_m, known_quads[wide]),
        MAPPED_STRUCTURE: (whole_m, known_quads[~wide]),
        MAPPED_BARS: bars,
        NOT_SURVEYED: (corners_m, quads[of == UNKNOWN]),
    }
    return {name: surface for name, surface in surfaces.items() if len(surface[1])}


def _plates(points: SeenPoints, nodes: Sequence[CloudNode], known: Kinds) -> tuple[Plates, Plates]:
    """Return the plates of clouds, with their backs, and those of bars. points: of all clouds."""
    plates = plates_of(points, np.random.default_rng(SEED))
    plates = with_backs(standing(plates, known, OCCUPIED), known, FREE)
    has_bars = are_bars(plates, beams_on(plates, nodes))
    return plates.only(~has_bars), plates.only(has_bars)


def scene_of(surfaces: Mapping[str, tuple[np.ndarray, np.ndarray]]) -> trimesh.Scene:
    """Return a scene of corners (n, 3) and quads (m, 4), by their names."""
    scene = trimesh.Scene()
    for name, (corners_m, quads) in surfaces.items():
        faces = np.concatenate((quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]))
        mesh = trimesh.Trimesh(corners_m, faces, process=False)
        mesh.remove_unreferenced_vertices()
        scene.add_geometry(mesh, node_name=name)
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
