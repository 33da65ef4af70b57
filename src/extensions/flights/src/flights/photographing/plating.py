"""Which faces of an explored map are plating, and which are frames, beams, stanchions and the like."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import cKDTree

DISC_M = 1.0
"""Radius of the disc around a place, in its plane, that tells plating."""
FILLED = 0.4
"""Plating fills so much of the disc: half of it at an edge. A strip of 0.5 m fills 0.32."""
CELL_M = 0.25
"""Faces in one cube that face one way are looked at together."""
OFF_M, ALIKE = 0.15, 0.9
"""Faces are of one plane if they are so near to it, and if the cosine between their normals is greater."""


def is_plating(corners_m: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Return which quads (m, 4) of corners (n, 3), m, are part of a wide plane."""
    faces_m = corners_m[quads]
    across = np.cross(faces_m[:, 2] - faces_m[:, 0], faces_m[:, 3] - faces_m[:, 1])
    lengths = np.linalg.norm(across, axis=1)
    areas_m2, normals = 0.5 * lengths, across / np.maximum(lengths, 1e-12)[:, None]
    centres_m = faces_m.mean(axis=1)
    cells = np.column_stack((np.floor(centres_m / CELL_M), np.rint(1.5 * normals))).astype(np.int64)
    _, of = np.unique(cells, axis=0, return_inverse=True)
    return _filled(*_together(of, centres_m, normals, areas_m2))[of] > FILLED


def _together(
    of: np.ndarray, centres_m: np.ndarray, normals: np.ndarray, areas_m2: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return middles (k, 3), unit normals (k, 3) and areas (k,) of groups; of: (m,) that of each face."""
    areas = np.bincount(of, areas_m2)

    def mean(values: np.ndarray) -> np.ndarray:
        sums = [np.bincount(of, areas_m2 * values[:, axis]) for axis in range(3)]
        return np.stack(sums, axis=1) / np.maximum(areas, 1e-12)[:, None]

    towards = mean(normals)
    return mean(centres_m), towards / np.maximum(np.linalg.norm(towards, axis=1), 1e-12)[:, None], areas


def _filled(middles_m: np.ndarray, normals: np.ndarray, areas_m2: np.ndarray) -> np.ndarray:
    """Return (k,) the share, about 0..1, of its disc that the plane of each group fills."""
    one, other = cKDTree(middles_m).query_pairs(DISC_M, output_type="ndarray").T
    way_m = middles_m[other] - middles_m[one]
    alike = (normals[one] * normals[other]).sum(axis=1) > ALIKE
    near = np.abs((way_m * normals[one]).sum(axis=1)) < OFF_M
    one, other = one[alike & near], other[alike & near]
    count = len(areas_m2)
    around_m2 = np.bincount(one, areas_m2[other], count) + np.bincount(other, areas_m2[one], count)
    filled: np.ndarray = (areas_m2 + around_m2) / (math.pi * DISC_M**2)
    return filled
