"""The bodies of a mesh: triangles that hang together, and whether they enclose a space."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

SAME_M = 1e-4
"""Corners that are nearer are one: an STL writes each corner once for each triangle, in single precision,
which tells places 1 km away to 0.06 mm.
"""


def joined_corners(triangles_m: np.ndarray, parts: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return the places (n, 3) of corners, m, and the numbers (m, 3) of those of triangles (m, 3, 3).

    parts: (m,) thing of each triangle. Corners of two things are two, even where they touch.
    """
    corners = np.rint(triangles_m.reshape(-1, 3) / SAME_M).astype(np.int64)
    if parts is not None:
        corners = np.column_stack((corners, np.repeat(parts, 3)))
    places, numbers = np.unique(corners, axis=0, return_inverse=True)
    return places[:, :3] * SAME_M, numbers.reshape(-1, 3)


def bodies_of(triangles_m: np.ndarray, parts: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return the body (m,) of each triangle, and which bodies (k,) are closed: each edge runs both ways.

    triangles_m, parts: as of `joined_corners`.
    """
    _, faces = joined_corners(triangles_m, parts)
    edges = np.concatenate((faces[:, (0, 1)], faces[:, (1, 2)], faces[:, (2, 0)]))
    size = int(faces.max(initial=-1)) + 1
    linked = coo_matrix((np.ones(len(edges)), edges.T), shape=(size, size))
    count, of_corner = connected_components(linked, directed=False)
    unpaired = (linked - linked.T).tocoo()
    is_open = np.zeros(count, bool)
    is_open[of_corner[unpaired.row[unpaired.data != 0]]] = True
    return of_corner[faces[:, 0]], ~is_open
