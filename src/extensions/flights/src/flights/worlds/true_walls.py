"""The true walls for a map: the faces of a world's solids that are visible from inside, at one height."""

from __future__ import annotations

from typing import Sequence

import numpy as np
from scipy import ndimage

from flights.errors import ScenarioError
from flights.worlds.floor_plan import Outline

PIECE_M = 0.05
"""Faces are cut into pieces of at most this length. Each piece is visible as a whole or not at all."""

CELL_M = 0.05
"""Cell size of the grid of reachable places. A gap narrower than this counts as closed."""

_OFF_FACE_M = 0.75 * CELL_M


def seen_faces(outlines: Sequence[Outline], height_m: float, inside_xy: tuple[float, float]) -> np.ndarray:
    """Return the faces (n, 2, 2: start and end, x and y, in `world`) that border on the space around a place.

    The outlines must be convex, as `floor_plan.outlines` makes them. Faces inside other shapes, and those on
    the far side of a closed wall, are left out.

    Raises:
        ScenarioError: no shape stands at this height, or one stands on the place.
    """
    corners = [o.outline_xy for o in outlines if o.blocks(height_m) and len(o.outline_xy) > 2]
    if not corners:
        raise ScenarioError(f"Nothing solid stands at a height of {height_m:g} m: there are no walls to map.")
    reachable = _Reachable(corners, inside_xy)
    pieces, normals = (np.concatenate(parts) for parts in zip(*map(_pieces, corners)))
    return _joined(pieces[reachable(pieces.mean(axis=1) + _OFF_FACE_M * normals)])


def inside(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return which points (n, 2) lie in a convex polygon with corners (m, 2), counter-clockwise."""
    edges = np.roll(corners, -1, axis=0) - corners
    offsets = points[:, None, :] - corners[None, :, :]
    turns = edges[:, 0] * offsets[:, :, 1] - edges[:, 1] * offsets[:, :, 0]
    return np.all(turns >= 0.0, axis=1)


class _Reachable:
    """Finds the places that can be reached from a start without crossing a solid, by flooding a grid."""

    def __init__(self, solids: Sequence[np.ndarray], start_xy: Sequence[float]) -> None:
        low = np.min([c.min(axis=0) for c in solids], axis=0) - 2 * CELL_M
        high = np.max([c.max(axis=0) for c in solids], axis=0) + 2 * CELL_M
        self._low = low = np.minimum(low, np.array(start_xy) - 2 * CELL_M)
        self._shape = tuple(np.ceil((np.maximum(high, start_xy) - low) / CELL_M).astype(int) + 2)
        free = np.ones(self._shape, dtype=bool)
        for corners in solids:
            self._fill(free, corners)
        regions, _ = ndimage.label(free)
        here = regions[self._cells(np.array([start_xy]))][0]
        if not here:
            raise ScenarioError(
                f"A solid stands at ({start_xy[0]:g}, {start_xy[1]:g}), where the walls are looked at from."
            )
        self._reached = regions == here

    def __call__(self, points: np.ndarray) -> np.ndarray:
        return self._reached[self._cells(points)]

    def _cells(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        indices = np.clip(np.floor((points - self._low) / CELL_M).astype(int), 0, np.array(self._shape) - 1)
        return indices[:, 0], indices[:, 1]

    def _fill(self, free: np.ndarray, corners: np.ndarray) -> None:
        first = np.floor((corners.min(axis=0) - self._low) / CELL_M).astype(int)
        last = np.ceil((corners.max(axis=0) - self._low) / CELL_M).astype(int)
        block = tuple(slice(a, b) for a, b in zip(first, last))
        xs, ys = (self._low[i] + (np.arange(first[i], last[i]) + 0.5) * CELL_M for i in (0, 1))
        centres = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=-1).reshape(-1, 2)
        free[block] &= ~inside(centres, corners).reshape(len(xs), len(ys))


def _pieces(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cut a polygon's edges into pieces (n, 2, 2). Return them and their outward normals (n, 2)."""
    pieces, normals = [], []
    for start, end in zip(corners, np.roll(corners, -1, axis=0)):
        along = end - start
        count = max(1, int(np.ceil(np.linalg.norm(along) / PIECE_M)))
        steps = start + np.linspace(0.0, 1.0, count + 1)[:, None] * along
        pieces.append(np.stack((steps[:-1], steps[1:]), axis=1))
        outward = np.array((along[1], -along[0])) / np.linalg.norm(along)
        normals.append(np.tile(outward, (count, 1)))
    return np.concatenate(pieces), np.concatenate(normals)


def _joined(pieces: np.ndarray) -> np.ndarray:
    """Join successive pieces of one line."""
    joined: list[np.ndarray] = []
    for piece in pieces:
        if joined and np.allclose(joined[-1][1], piece[0]) and _in_line(joined[-1], piece):
            joined[-1] = np.array((joined[-1][0], piece[1]))
        else:
            joined.append(piece)
    return np.array(joined).reshape(-1, 2, 2)


def _in_line(first: np.ndarray, second: np.ndarray) -> bool:
    a, b = first[1] - first[0], second[1] - second[0]
    return abs(a[0] * b[1] - a[1] * b[0]) < 1e-9 * max(1.0, float(np.linalg.norm(a))) and float(a @ b) > 0.0
