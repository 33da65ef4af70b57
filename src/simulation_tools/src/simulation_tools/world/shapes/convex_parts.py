"""Cuts a mesh into convex parts, as a body that moves needs them: PyBullet takes the hull of each part.

A connected piece that is convex is one part. Any other piece becomes a thin slab behind each of its
triangles. So it stays open where it is open, like the triangle meshes of Gazebo's physics.
"""

from __future__ import annotations

import numpy as np

from simulation_tools.world.shapes.triangle_mesh import TriangleMesh

MAX_SLABS = 500
"""Triangles of the concave pieces of a part. With more of them, each piece is taken for its hull. A body of
500 slabs that stands costs 0.25 ms a step; of two that are inside each other, some 35 ms."""
SLAB_M = 0.01
AREA_TOLERANCE, DEPTH_TOLERANCE = 0.05, 0.01
"""A piece is convex if its area is that of its hull within this part, and if no triangle's middle is deeper
under the hull than this part of the piece's size."""


def convex_parts(mesh: TriangleMesh, max_slabs: int = MAX_SLABS) -> tuple[list[np.ndarray], bool]:
    """Return the corners (n, 3) of each convex part, and whether a concave piece is filled up to its hull."""
    pieces = [mesh.vertices[triangles] for triangles in connected_pieces(mesh)]
    concave = [not _is_convex(corners) for corners in pieces]
    is_too_fine = sum(len(corners) for corners, is_concave in zip(pieces, concave) if is_concave) > max_slabs
    parts: list[np.ndarray] = []
    for corners, is_concave in zip(pieces, concave):
        if is_concave and not is_too_fine:
            parts += _slabs(corners)
        else:
            parts.append(np.unique(corners.reshape(-1, 3), axis=0))
    return parts, is_too_fine and any(concave)


def connected_pieces(mesh: TriangleMesh) -> list[np.ndarray]:
    """Return the triangles (m, 3) of each piece whose triangles share corners, the piece of the first first.

    Corners at one place count as one, because an STL file repeats them for each triangle.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    size = max(float(np.ptp(mesh.vertices, axis=0).max()), 1e-12)
    _, place = np.unique(np.round(mesh.vertices / (1e-7 * size)), axis=0, return_inverse=True)
    place = place.ravel()
    corners = place[mesh.triangles]
    first, other = np.repeat(corners[:, 0], 2), corners[:, 1:].ravel()
    count = int(place.max()) + 1
    links = coo_matrix((np.ones(len(first), bool), (first, other)), (count, count))
    number, label = connected_components(links, directed=False)
    of_triangle = label[corners[:, 0]]
    order = np.argsort(of_triangle, kind="stable")
    ends = np.cumsum(np.bincount(of_triangle, minlength=number))
    groups = [mesh.triangles[group] for group in np.split(order, ends[:-1]) if len(group)]
    return groups


def _is_convex(corners: np.ndarray) -> bool:
    """Whether triangles (n, 3, 3) lie on their own hull and cover it; flat ones are convex too."""
    from scipy.spatial import ConvexHull, QhullError

    points = np.unique(corners.reshape(-1, 3), axis=0)
    size = float(np.ptp(points, axis=0).max())
    try:
        hull = ConvexHull(points)
    except QhullError:  # all points in one plane
        return True
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area_m2 = 0.5 * float(np.linalg.norm(sides, axis=1).sum())
    if not abs(area_m2 - hull.area) <= AREA_TOLERANCE * hull.area:
        return False
    if len(corners) > MAX_SLABS:  # it is taken for its hull in any case, and its area is the hull's
        return True
    middles = corners.mean(axis=1)
    depth_m = -(middles @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)
    return bool(depth_m.max() <= DEPTH_TOLERANCE * size)


def _slabs(corners: np.ndarray) -> list[np.ndarray]:
    """Return the corners (6, 3) of a slab behind each triangle that has an area."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    corners, normals = corners[lengths > 1e-12], normals[lengths > 1e-12] / lengths[lengths > 1e-12, None]
    return list(np.concatenate((corners, corners - SLAB_M * normals[:, None]), axis=1))
