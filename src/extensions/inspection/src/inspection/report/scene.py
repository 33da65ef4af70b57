"""The surface as triangles with a state, for the 3D view and the picture that stands in for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from inspection.survey.surface.edges import edge_lines
from inspection.survey.surface.mesh_file import Mesh
from inspection.survey.surface.of_mesh import EDGE_M
from inspection.survey.surface.samples import clipped, halved, normals_of
from inspection.survey.surface_record import MOST, SurfaceRecord

SEEN, OPEN, OUT_OF_REACH, UNKNOWN = range(4)
"""States: photographed; could be, but is not; cannot be; nothing is known."""
FINEST_M, MOST_TRIANGLES = 0.3, 180_000
COARSE_M, COARSER = 1.2, 1.3
MOST_EDGES = 30_000
"""Of a mesh that are drawn, the longest."""


@dataclass(frozen=True)
class Scene:
    """triangles_m: (n, 3, 3), seen from the side of their normals. states: (n,). edges_m: (k, 2, 3), ends."""

    triangles_m: np.ndarray
    states: np.ndarray
    edges_m: np.ndarray


def scene_of(mesh: Mesh, surface: SurfaceRecord | None) -> Scene:
    """Return the sides of the mesh that face the air; without a record all triangles, state unknown."""
    if surface is None:
        low_m, high_m = mesh.bounds_m()
        inside = clipped(mesh.triangles_m, low_m - EDGE_M, high_m + EDGE_M)
        inside &= np.ptp(mesh.triangles_m, axis=1).max(axis=1) < 2.0 * np.ptp([low_m, high_m], axis=0).max()
        states = np.full(int(inside.sum()), UNKNOWN)
        return Scene(mesh.triangles_m[inside], states, _edges_m(mesh, low_m - EDGE_M, high_m + EDGE_M))
    low_m, high_m = surface.points_m.min(axis=0) - EDGE_M, surface.points_m.max(axis=0) + EDGE_M
    coarse = subdivided(mesh.triangles_m, COARSE_M, low_m, high_m)
    coarse = coarse[surface.patches_at(coarse.mean(axis=1), None, COARSE_M) >= 0]
    longest_m = FINEST_M
    while True:
        triangles_m, states = _with_states(subdivided(coarse, longest_m, low_m, high_m), surface, longest_m)
        if len(states) <= MOST_TRIANGLES or longest_m > COARSE_M:
            return Scene(triangles_m, states, _edges_m(mesh, low_m, high_m))
        longest_m *= COARSER


def subdivided(
    triangles_m: np.ndarray, longest_m: float, low_m: np.ndarray, high_m: np.ndarray
) -> np.ndarray:
    """Return triangles that cover the same, halved at their longest side, without those outside a box."""
    done = []
    left = triangles_m
    while len(left) and len(left) < 20 * MOST_TRIANGLES:
        left = left[clipped(left, low_m, high_m)]
        sides = np.linalg.norm(left[:, (1, 2, 0)] - left, axis=2)
        small = sides.max(axis=1) <= longest_m
        done.append(left[small])
        left = left[~small]
        left = halved(left)
    return np.concatenate(done) if done else np.zeros((0, 3, 3))


def _edges_m(mesh: Mesh, low_m: np.ndarray, high_m: np.ndarray) -> np.ndarray:
    """Return the longest edges (k, 2, 3) of a mesh in a box."""
    edges_m = edge_lines(mesh.triangles_m, mesh.joined)
    edges_m = edges_m[((edges_m >= low_m) & (edges_m <= high_m)).all(axis=(1, 2))]
    order = np.argsort(-np.linalg.norm(edges_m[:, 1] - edges_m[:, 0], axis=1), kind="stable")
    kept: np.ndarray = edges_m[order[:MOST_EDGES]]
    return kept


def _with_states(
    triangles_m: np.ndarray, surface: SurfaceRecord, longest_m: float
) -> tuple[np.ndarray, np.ndarray]:
    normals, _ = normals_of(triangles_m)
    middles = triangles_m.mean(axis=1)
    kept, states = [], []
    reach_m = max(1.2 * surface.side_m, 0.6 * longest_m)
    for sign, order in ((1.0, (0, 1, 2)), (-1.0, (0, 2, 1))):
        patch = surface.patches_at(middles, sign * normals, reach_m)
        there = patch >= 0
        kept.append(triangles_m[there][:, order])
        of = patch[there]
        states.append(
            np.where(surface.is_shown[of], SEEN, np.where(surface.reachable[of] >= MOST, OPEN, OUT_OF_REACH))
        )
    return np.concatenate(kept), np.concatenate(states)
