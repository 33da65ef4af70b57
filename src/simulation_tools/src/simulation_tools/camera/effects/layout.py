"""Where effects lie on a world: seams, upper edges, and the places in the noise, by the seed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from simulation_tools.camera.effects.amounts import EFFECTS, Effects
from simulation_tools.camera.surfaces import Surfaces
from simulation_tools.camera.textures import clouds

PLATE_M = (6.0, 2.4)
"""Length and height of a plate: seams are so far apart, along u and v of a face."""
STEEP = 0.7
"""On faces whose normal has less than this of the vertical, water runs down."""
LEVEL, LEAST_EDGE_M = 0.05, 0.05
"""An edge from which runs hang climbs less than this share of its length, and is at least so long."""
BANDS_M = (1.2, 5.5)
"""About so high other coatings begin and end."""


class Layout(NamedTuple):
    """Effects as the kernels need them.

    amounts: (len(EFFECTS),). seed. seams_m: (2,) the first seam's u and v. bands_m: (2,) z at which the
    coating changes. shifts: (faces, 2) of the noise, texels. axes: (faces, 3, 3): normal, u, v. offsets_m:
    (faces,). first: (faces + 1,) and edges_m: (n, 3): the upper edges of each face: u from, u to, v.
    clouds: (side, side) noise.
    """

    amounts: np.ndarray
    seed: int
    seams_m: np.ndarray
    bands_m: np.ndarray
    shifts: np.ndarray
    axes: np.ndarray
    offsets_m: np.ndarray
    first: np.ndarray
    edges_m: np.ndarray
    clouds: np.ndarray


def layout_of(effects: Effects, surfaces: Surfaces) -> Layout:
    """Return where the effects lie on surfaces. The same seed and world give the same places."""
    rng = np.random.default_rng(effects.seed)
    seams_m, bands_m = rng.uniform(0.0, PLATE_M), BANDS_M + rng.uniform(-0.3, 0.3, 2)
    first, edges_m = upper_edges(surfaces)
    return Layout(
        np.array([getattr(effects, name) for name in EFFECTS], float),
        effects.seed,
        seams_m,
        bands_m,
        rng.uniform(0.0, 1000.0, (len(surfaces.offsets_m), 2)),
        np.stack((surfaces.normals, surfaces.u_axes, surfaces.v_axes), axis=1),
        np.asarray(surfaces.offsets_m, float),
        first,
        edges_m,
        clouds(2, 1.3),
    )


def upper_edges(surfaces: Surfaces) -> tuple[np.ndarray, np.ndarray]:
    """Return (faces + 1,) where each face's edges begin, and edges (n, 3): u from, u to, v, m.

    They are the level edges of faces that are not level, with the face below and nothing of it above.
    """
    face = surfaces.face_of
    u, v = (
        np.einsum("tij,tj->ti", surfaces.corners_m.astype(float), axes[face])
        for axes in (surfaces.u_axes, surfaces.v_axes)
    )
    steep = np.abs(surfaces.normals[face, 2]) < STEEP
    found = []
    for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        length = np.abs(u[:, a] - u[:, b])
        level = steep & (np.abs(v[:, a] - v[:, b]) < LEVEL * length) & (length > LEAST_EDGE_M)
        low, high = np.minimum(u[:, a], u[:, b]), np.maximum(u[:, a], u[:, b])
        middle = 0.5 * (v[:, a] + v[:, b])
        found.append(np.column_stack((face, low, high, middle, v[:, c] < middle))[level])
    edges = np.concatenate(found)
    _, at, counts = np.unique(np.round(1e3 * edges[:, :4]), axis=0, return_index=True, return_counts=True)
    edges = edges[at[counts == 1]]
    edges = edges[edges[:, 4] > 0.0]
    edges = edges[np.argsort(edges[:, 0], kind="stable")]
    first = np.searchsorted(edges[:, 0], np.arange(len(surfaces.offsets_m) + 1))
    return first.astype(np.int32), np.ascontiguousarray(edges[:, 1:4])
