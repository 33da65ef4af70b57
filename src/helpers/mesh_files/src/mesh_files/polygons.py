"""Polygons as triangles. A fan would cover what lies outside of a polygon with an inward corner."""

from __future__ import annotations

from typing import Sequence

import numpy as np

FLAT = 1e-9
"""Twice the area of a corner's triangle, of the longest side squared, from which on it turns inward."""


def triangulated(vertices: np.ndarray, polygons: Sequence[Sequence[int]] | np.ndarray) -> np.ndarray:
    """Return triangles (m, 3) of polygons.

    vertices: (n, 3). polygons: numbers of the corners of each; an array (k, size) if all have as many.
    """
    found, by_size = list[np.ndarray](), dict[int, Sequence[Sequence[int]] | np.ndarray]()
    if isinstance(polygons, np.ndarray):
        by_size[polygons.shape[1]] = polygons
    else:
        for size in {len(each) for each in polygons}:
            by_size[size] = [each for each in polygons if len(each) == size]
    for size, several in by_size.items():
        if size < 3:
            continue
        corners = np.array(several, np.int64)
        bent = has_inward_corner(vertices[corners]) if size > 3 else np.zeros(len(corners), bool)
        for k in range(1, size - 1):
            found.append(corners[~bent][:, (0, k, k + 1)])
        for each in corners[bent]:
            found.append(each[np.array(ears(vertices[each]))])
    return np.concatenate(found) if found else np.zeros((0, 3), np.int64)


def has_inward_corner(corners: np.ndarray) -> np.ndarray:
    """Return (k,) which polygons, corners (k, n, 3), turn inward somewhere."""
    turns = _turns(corners)
    side = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    bent: np.ndarray = (turns < -FLAT * side[:, None] ** 2).any(axis=1)
    return bent


def ears(corners: np.ndarray) -> list[tuple[int, int, int]]:
    """Return triangles of one polygon, corners (n, 3): ear after ear is cut off (Meisters, 1975)."""
    flat, left, found = _flat(corners), list(range(len(corners))), []
    while len(left) > 3:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            if _cross(flat[a], flat[b], flat[c]) > 0.0 and not any(
                _is_within(flat[p], flat[a], flat[b], flat[c]) for p in left if p not in (a, b, c)
            ):
                found.append((a, b, c))
                del left[k]
                break
        else:  # corners on one line, or sides that cross each other: nothing is left that has an area
            return [*found, *((left[0], left[k], left[k + 1]) for k in range(1, len(left) - 1))]
    return [*found, (left[0], left[1], left[2])]


def _normals(corners: np.ndarray) -> np.ndarray:
    """Return Newell's normals (k, 3) of polygons (k, n, 3); their length is twice the area."""
    from_first = corners - corners[:, :1]
    normals: np.ndarray = np.cross(from_first, np.roll(from_first, -1, axis=1)).sum(axis=1)
    return normals


def _turns(corners: np.ndarray) -> np.ndarray:
    """Return (k, n) twice the area of the triangle of each corner and its neighbours, signed."""
    normals = _normals(corners)
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    before, after = corners - np.roll(corners, 1, axis=1), np.roll(corners, -1, axis=1) - corners
    turns: np.ndarray = np.einsum("kni,ki->kn", np.cross(before, after), normals)
    return turns


def _flat(corners: np.ndarray) -> np.ndarray:
    """Return the places (n, 2) of a polygon's corners in its plane, anticlockwise."""
    normal = _normals(corners[None])[0]
    normal = normal / np.maximum(np.linalg.norm(normal), 1e-300)
    u = np.cross(np.eye(3)[np.abs(normal).argmin()], normal)
    u /= np.linalg.norm(u)
    flat: np.ndarray = (corners - corners[0]) @ np.column_stack((u, np.cross(normal, u)))
    return flat


def _cross(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _is_within(p: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> bool:
    """Return whether a point lies in an anticlockwise triangle, or on its side, but not at its corners."""
    if any((p == each).all() for each in (a, b, c)):
        return False
    return _cross(a, b, p) >= 0.0 and _cross(b, c, p) >= 0.0 and _cross(c, a, p) >= 0.0
