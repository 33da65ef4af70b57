"""Where the surfaces of a world are truly rusted, by its file of defects."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy import ndimage

from inspection.findings.merging import Finding, thinned
from simulation_tools.camera.defects import KINDS, Decals, decals_of, read_defects
from simulation_tools.camera.surfaces import Surfaces, surfaces_of
from simulation_tools.camera.textures import clouds
from simulation_tools.sdf.parser import load_world

STEP_M, CELL_M = 0.01, 0.25
"""Between places that are asked whether they are rusted; a finding holds those of one cell."""
HALF, ROUGH, TEXELS, FADE = 0.5, 0.22, 60.0, 6.0
"""A place is rusted where the decal covers half of the coating (`simulation_tools.camera.kernels.marked`)."""
REACH = 1.6
"""Half sizes of its spot beside which no decal of rust colours anything."""
BESIDE_M = 0.02
"""From where a ray asks whether a plane has a surface at a place."""


def is_rusted(places_m: np.ndarray, decals: Decals, rows: range) -> np.ndarray:
    """Return which places (n, 2), u and v on a face, a decal of rust covers at least half."""
    rusted, tile = np.zeros(len(places_m), bool), clouds(2, 1.3)
    for row in rows:
        u, v, cosine, sine, half_length, half_width = decals.place[row]
        near = np.flatnonzero((np.abs(places_m - (u, v)) < 2.3 * max(half_length, half_width)).all(axis=1))
        along = (places_m[near] - (u, v)) @ np.array(((cosine, -sine), (sine, cosine)))
        texels = along * TEXELS / max(half_length, half_width) + decals.shift[row]
        rough = ndimage.map_coordinates(tile, texels[:, ::-1].T, order=1, mode="grid-wrap")
        far = np.hypot(along[:, 0] / half_length, along[:, 1] / half_width)
        reach = (np.abs(along) < REACH * np.array((half_length, half_width))).all(axis=1)
        rusted[near] |= reach & ((1.0 - far - ROUGH * rough) * FADE > HALF)
    return rusted


def by_cells(rusted_m: np.ndarray, normal: np.ndarray, thing: str, first: int) -> list[Finding]:
    """Return a finding for each cell that holds rusted places (n, 3), of their true area."""
    cells, found = np.floor(rusted_m / CELL_M), list[Finding]()
    for cell in np.unique(cells, axis=0):
        inside = rusted_m[(cells == cell).all(axis=1)]
        area_m2, places_m = STEP_M**2 * len(inside), thinned(inside)
        place = tuple(inside.mean(axis=0).tolist()), tuple(normal.tolist()), CELL_M, area_m2, (thing,)
        found.append(Finding(first + len(found), "rust", *place, places_m=places_m))
    return found


def true_rust(world: Path, marks: Path) -> list[Finding]:
    """Return a finding for each cell of the world's surfaces that is rusted."""
    given = read_defects(marks)
    surfaces = surfaces_of(load_world(str(world)), given.coatings)
    decals, found = decals_of(given.defects, surfaces), list[Finding]()
    for face, (first, last) in enumerate(zip(decals.first[:-1], decals.first[1:])):
        rows = [row for row in range(first, last) if decals.kind[row] == KINDS.index("rust")]
        if rows:
            rusted_m = _rusted_on(face, rows, decals, surfaces)
            found += by_cells(rusted_m, surfaces.normals[face], "", len(found) + 1)
    return found


def _rusted_on(face: int, rows: list[int], decals: Decals, surfaces: Surfaces) -> np.ndarray:
    """Return the rusted places (n, 3) of a face. Each counts once, also where spots overlap."""
    asked = []
    for row in rows:
        u, v, _, _, half_length, half_width = decals.place[row]
        reach_m = 1.5 * REACH * max(half_length, half_width)
        low, high = (np.floor((np.array((u, v)) + side * reach_m) / STEP_M).astype(int) for side in (-1, 1))
        grid = np.meshgrid(*(np.arange(a, b + 1) for a, b in zip(low, high)), indexing="ij")
        asked.append(np.stack(grid, -1).reshape(-1, 2))
    on_face_m = STEP_M * (np.unique(np.concatenate(asked), axis=0) + 0.5)
    rusted_m = on_face_m[np.logical_or.reduce([is_rusted(on_face_m, decals, range(r, r + 1)) for r in rows])]
    normal = surfaces.normals[face]
    axes = np.stack((surfaces.u_axes[face], surfaces.v_axes[face]))
    places_m = rusted_m @ axes + surfaces.offsets_m[face] * normal
    down = np.tile(-normal, (len(places_m), 1))
    met, far_m = surfaces.nearest(places_m + BESIDE_M * normal, down)
    return places_m[(met == face) & (np.abs(far_m - BESIDE_M) < 0.5 * BESIDE_M)]
