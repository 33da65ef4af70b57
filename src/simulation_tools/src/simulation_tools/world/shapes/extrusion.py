"""Extruded polylines of SDF: outlines on the ground that are drawn up to a height, with holes.

Inside is what an odd number of outlines surrounds, as in Gazebo. Each horizontal strip between two corners' y
holds trapezoids only. They are the caps; the outlines themselves are the walls.
"""

from __future__ import annotations

import numpy as np

from simulation_tools.sdf.elements import Polyline
from simulation_tools.world.shapes.terrain import MeshError
from simulation_tools.world.shapes.triangle_mesh import TriangleMesh

MERGED_M = 1e-4
"""Corners that are nearer to each other than this are one, as in Gazebo."""


def trapezoids(shape: Polyline) -> np.ndarray:
    """Return the convex pieces of what the outlines surround, (n, 4, 2), counter-clockwise.

    Raises MeshError when an outline crosses another one or itself, or when nothing is inside.
    """
    return _trapezoids(_edges(shape))


def _trapezoids(edges: np.ndarray) -> np.ndarray:
    levels = np.unique(edges[:, :, 1])
    found = [_strip(edges, low, high) for low, high in zip(levels, levels[1:])]
    quads = np.concatenate(found) if found else np.empty((0, 4, 2))
    quads = quads[_widths(quads) > 0.0]
    if not len(quads):
        raise MeshError("The outline of a <polyline> surrounds nothing.")
    return quads


def prisms(shape: Polyline) -> list[np.ndarray]:
    """Return the corners (8, 3) of each convex part of the shape."""
    return [
        np.concatenate([np.column_stack((quad, np.full(4, z))) for z in (0.0, shape.height_m)])
        for quad in trapezoids(shape)
    ]


def extruded(shape: Polyline) -> TriangleMesh:
    """Return the closed surface, its triangles counter-clockwise from outside. Raises MeshError."""
    edges = _edges(shape)
    caps = _trapezoids(edges)
    bottom, top = (np.dstack((caps, np.full(caps.shape[:2], z))) for z in (0.0, shape.height_m))
    quads = np.concatenate((bottom[:, ::-1], top, _walls(edges, caps, shape.height_m)))
    corners, index = np.unique(quads.reshape(-1, 3), axis=0, return_inverse=True)
    index = index.reshape(-1, 4)
    triangles = np.concatenate((index[:, (0, 1, 2)], index[:, (0, 2, 3)]))
    a, b, c = triangles.T
    has_area = (a != b) & (b != c) & (c != a)  # a trapezoid may be a triangle
    return TriangleMesh(corners, triangles[has_area].astype(np.int32))


def _edges(shape: Polyline) -> np.ndarray:
    """Return the edges (n, 2, 2) of all outlines, without those that have no length."""
    loops = []
    for outline in shape.outlines:
        points = np.array(outline)
        apart = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1) > MERGED_M
        points = points[apart]
        loops.append(np.stack((points, np.roll(points, -1, axis=0)), axis=1))
    return np.concatenate(loops)


def _crossings(edges: np.ndarray, y: float) -> np.ndarray:
    """Return where edges (n, 2, 2) that reach the height y have it, x (n,)."""
    (x0, y0), (x1, y1) = edges[:, 0].T, edges[:, 1].T
    share = (y - y0) / (y1 - y0)
    # the ends exactly, so that neighbours share their corners
    return np.where(y == y0, x0, np.where(y == y1, x1, x0 + share * (x1 - x0)))


def _widths(quads: np.ndarray) -> np.ndarray:
    """Return the greater of the lower and the upper width of trapezoids (n, 4, 2)."""
    return np.maximum(quads[:, 1, 0] - quads[:, 0, 0], quads[:, 2, 0] - quads[:, 3, 0])


def _strip(edges: np.ndarray, low: float, high: float) -> np.ndarray:
    """Return the trapezoids (n, 4, 2) between two heights; no corner is between them."""
    across = edges[(edges[:, :, 1].min(axis=1) <= low) & (edges[:, :, 1].max(axis=1) >= high)]
    at_low, at_high = _crossings(across, low), _crossings(across, high)
    order = np.argsort(at_low + at_high)
    at_low, at_high = at_low[order], at_high[order]
    if (np.diff(at_low) < -MERGED_M).any() or (np.diff(at_high) < -MERGED_M).any():
        raise MeshError("The outline of a <polyline> crosses itself or another one.")
    y_low, y_high = np.full(len(order) // 2, low), np.full(len(order) // 2, high)
    left, right = slice(0, None, 2), slice(1, None, 2)
    corners = (at_low[left], y_low), (at_low[right], y_low), (at_high[right], y_high), (at_high[left], y_high)
    return np.stack([np.column_stack(corner) for corner in corners], axis=1)


def _walls(edges: np.ndarray, quads: np.ndarray, height_m: float) -> np.ndarray:
    """Return the upright quadrilaterals (n, 4, 3), counter-clockwise from outside.

    They are the sides of the trapezoids, and those level edges that have the inside on one side only.
    """
    level = edges[edges[:, 0, 1] == edges[:, 1, 1]]
    left, right = level[:, :, 0].min(axis=1), level[:, :, 0].max(axis=1)
    middle, y = 0.5 * (left + right), level[:, 0, 1]
    above = _covered(quads[:, 0], quads[:, 1], middle, y)
    below = _covered(quads[:, 3], quads[:, 2], middle, y)
    ahead = np.stack((np.column_stack((left, y)), np.column_stack((right, y))), axis=1)
    paths = np.concatenate(  # each with the inside to its left
        (quads[:, (1, 2)], quads[:, (3, 0)], ahead[above & ~below], ahead[below & ~above][:, ::-1])
    )
    start, end = paths[:, 0], paths[:, 1]
    foot, top = np.zeros((len(paths), 1)), np.full((len(paths), 1), height_m)
    corners = (start, foot), (end, foot), (end, top), (start, top)
    return np.stack([np.hstack(corner) for corner in corners], axis=1)


def _covered(left: np.ndarray, right: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Whether points (x, y), (n,), lie on one of the level sides from left to right, (m, 2) each."""
    on_side = (left[:, 1] == y[:, None]) & (left[:, 0] <= x[:, None]) & (x[:, None] <= right[:, 0])
    return on_side.any(axis=1)
