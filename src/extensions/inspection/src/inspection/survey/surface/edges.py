"""Edges and welds of a mesh: where two of its faces meet at an angle, or one ends."""

from __future__ import annotations

import numpy as np

from inspection.survey.surface.samples import normals_of
from mesh_files.bodies import joined_corners

SHARP = 0.87
"""Faces whose normals have a greater cosine between them are one plate."""
STEP_M = 0.05
"""Between places on an edge; two edges nearer than this are one."""


def edge_lines(triangles_m: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Return the ends (k, 2, 3) of all edges of triangles (m, 3, 3) of things (m,)."""
    normals, _ = normals_of(triangles_m)
    places_m, faces = joined_corners(triangles_m, parts)
    sides = np.sort(np.concatenate((faces[:, (0, 1)], faces[:, (1, 2)], faces[:, (2, 0)])), axis=1)
    of_face = np.tile(np.arange(len(faces)), 3)
    order = np.lexsort((sides[:, 1], sides[:, 0]))
    sides, of_face = sides[order], of_face[order]
    begins = np.flatnonzero(np.append(True, (sides[1:] != sides[:-1]).any(axis=1)))
    counts = np.diff(np.append(begins, len(sides)))
    is_edge = counts != 2
    pairs = begins[counts == 2]
    cosine = np.abs((normals[of_face[pairs]] * normals[of_face[pairs + 1]]).sum(axis=1))
    is_edge[counts == 2] = cosine < SHARP
    ends_m: np.ndarray = places_m[sides[begins[is_edge]]]
    return ends_m


def edge_places(triangles_m: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Return places (k, 3), STEP_M apart, on all edges of triangles (m, 3, 3) of things (m,)."""
    ends = edge_lines(triangles_m, parts)
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    numbers = np.maximum(np.rint(lengths / STEP_M).astype(int), 1)
    of = np.repeat(np.arange(len(ends)), numbers)
    along = (np.arange(len(of)) - np.repeat(np.cumsum(numbers) - numbers, numbers) + 0.5) / numbers[of]
    found = ends[of, 0] + along[:, None] * (ends[of, 1] - ends[of, 0])
    _, first = np.unique(np.floor(found / STEP_M + 1e-6).astype(np.int64), axis=0, return_index=True)
    return found[np.sort(first)]
