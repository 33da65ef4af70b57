"""Room and patches from a mesh."""

from __future__ import annotations

import math

import numpy as np

from flight_basics.errors import SurveyError
from inspection.survey.kernels.filling import mark_columns, reached_from
from inspection.survey.parameters import SurveyParameters
from inspection.survey.surface.mesh_file import NOT_SURVEYED, Mesh, is_mapped
from inspection.survey.surface.patches import Patches, grouped
from inspection.survey.surface.rays import Rays
from inspection.survey.surface.room import HOME_M, MOST_VOXELS, Room, is_sheltered, room_of
from inspection.survey.surface.samples import (
    Samples,
    SurfacePoints,
    clipped,
    normals_of,
    samples_in_turn,
    samples_within,
)
from inspection.survey.surface.surrounded import surrounded_voxels

EDGE_M = 0.6
"""More on each side of the box around a mesh."""
LEAST_VOXELS = 2.0
"""Along the longest side of the mesh."""
INTO_M = 1e-3
"""Samples count to the voxel this far behind them: walls on voxels' borders do not thicken inwards."""
SPACING = 0.4
"""Between samples of the surface, in voxels."""
FRONT = 1.5
"""A side of a surface is in the air if a place so many voxels before it is."""
BESIDE = 2
"""Voxels that are kept beside the air: its walls, and one more."""


def room_of_mesh(
    mesh: Mesh, parameters: SurveyParameters, home_m: np.ndarray | None = None
) -> tuple[Room, Samples, np.ndarray]:
    """Return the room, samples of the surface in it, and the triangles (m,) that reach into it.

    Raises:
        SurveyError: the mesh is too large or too small for its voxels, or the UAV fits nowhere.
    """
    p = parameters
    low_m, high_m = mesh.bounds_m()
    if (high_m - low_m).max() < LEAST_VOXELS * p.voxel:
        size = " x ".join(f"{v:.3g}" for v in high_m - low_m)
        raise SurveyError(
            f"The mesh spans {size} m, which is less than two voxels of {p.voxel:g} m: take smaller ones "
            "(--voxel), or check that its unit is the metre."
        )
    low = np.floor((low_m - EDGE_M - p.around_m) / p.voxel).astype(np.int64)
    high = np.ceil((high_m + EDGE_M + p.around_m) / p.voxel).astype(np.int64)
    size = (high - low)[::-1]
    if np.prod(size.astype(float)) > MOST_VOXELS:
        raise SurveyError(
            f"The mesh spans {' x '.join(f'{v:.0f}' for v in high_m - low_m)} m, too much for voxels of "
            f"{p.voxel:g} m: take larger ones (--voxel), or check that its unit is the metre."
        )
    corner_m = low * p.voxel
    near = np.flatnonzero(clipped(mesh.triangles_m, corner_m, high * p.voxel))
    blocked = _blocked(mesh.triangles_m[near], corner_m, size, p.voxel)
    kept_out = None
    if p.outside:
        blocked |= is_sheltered(blocked)
        kept_out = surrounded_voxels(mesh.triangles_m[near], blocked, corner_m, p.voxel)
        blocked[: int(np.floor((low_m - corner_m)[2] / p.voxel))] = True
    else:
        blocked, corner_m = _around_rooms(blocked, corner_m, p, home_m)
    room = room_of(blocked, corner_m, p.voxel, p.clearance_m, home_m, p.outside, kept_out)
    end_m = corner_m + np.array(room.air.shape[::-1]) * p.voxel
    near = near[clipped(mesh.triangles_m[near], corner_m, end_m)]
    samples = samples_within(mesh.triangles_m[near], SPACING * p.voxel, corner_m, end_m)
    normals, _ = normals_of(mesh.triangles_m[near])
    _, inside = _voxels_behind(samples, normals, corner_m, room.air.shape, p.voxel)
    kept = Samples(samples.points_m[inside], samples.triangles[inside], samples.areas_m2[inside])
    return room, kept, near


def _blocked(triangles_m: np.ndarray, corner_m: np.ndarray, size: np.ndarray, voxel_m: float) -> np.ndarray:
    """Return which voxels (d, h, w), the first of which begins at corner_m, triangles (m, 3, 3) cross."""
    normals, _ = normals_of(triangles_m)
    blocked = np.zeros(size, bool)
    for samples in samples_in_turn(triangles_m, SPACING * voxel_m, corner_m, corner_m + size[::-1] * voxel_m):
        index, inside = _voxels_behind(samples, normals, corner_m, blocked.shape, voxel_m)
        blocked[tuple(index[inside].T)] = True
    into = triangles_m - INTO_M * normals[:, None]
    mark_columns(np.ascontiguousarray(((into - corner_m) / voxel_m)[:, :, ::-1]), blocked)
    return blocked


def _voxels_behind(
    samples: Samples, normals: np.ndarray, corner_m: np.ndarray, shape: tuple[int, ...], voxel_m: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the voxels (n, 3), z first, just behind samples, and which of them (n,) there are.

    normals: (m, 3) of the triangles.
    """
    behind = samples.points_m - INTO_M * normals[samples.triangles]
    index = np.floor((behind - corner_m) / voxel_m).astype(np.int64)[:, ::-1]
    return index, ((index >= 0) & (index < shape)).all(axis=1)


def _around_rooms(
    blocked: np.ndarray, corner_m: np.ndarray, parameters: SurveyParameters, home_m: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the part of blocked voxels that air can be in from home or from any shelter; and its corner, m.

    So a small closed room on a wide ground takes the memory of the room.
    """
    begins = is_sheltered(blocked)
    if home_m is not None:
        index = np.floor(((home_m - corner_m) / parameters.voxel)[::-1]).astype(np.int64)
        reach = math.ceil((parameters.clearance_m + HOME_M) / parameters.voxel)
        low = np.clip(index - reach, 0, blocked.shape)
        begins[tuple(map(slice, low, np.clip(index + reach + 1, 0, blocked.shape)))] = True
    begins &= ~blocked
    if not begins.any():
        return blocked, corner_m
    first, last = reached_from(blocked, begins)
    low, high = np.maximum(first - BESIDE, 0), np.minimum(last + 1 + BESIDE, blocked.shape)
    return blocked[tuple(map(slice, low, high))].copy(), corner_m + low[::-1] * parameters.voxel


def patches_of_mesh(
    mesh: Mesh, room: Room, samples: Samples, near: np.ndarray, parameters: SurveyParameters
) -> Patches:
    """Return the patches of all sides of the surface that are in the UAV's air; see `sides_in_air`."""
    return grouped(sides_in_air(mesh, room, samples, near), mesh.names, parameters.patch)


def sides_in_air(mesh: Mesh, room: Room, samples: Samples, near: np.ndarray) -> SurfacePoints:
    """Return the samples of all sides of the surface that are in the UAV's air.

    A closed body shows one side: its outer one, or its inner one if the air is inside. A sheet shows both;
    one of an explored map shows its front.

    Raises:
        SurveyError: no side is in the air.
    """
    triangles_m = mesh.triangles_m[near]
    normals, _ = normals_of(triangles_m)
    bodies, is_closed = mesh.bodies
    bodies = bodies[near]
    sight = Rays(triangles_m)
    step_m = FRONT * room.voxel_m
    kept = []
    votes = []
    for sign in (1.0, -1.0):
        towards = sign * normals[samples.triangles]
        begins = samples.points_m + 1e-3 * towards
        free_m = sight.ranges_m(begins, towards)
        strict = room.at(room.air, begins + np.minimum(0.5 * free_m, step_m)[:, None] * towards) > 0
        votes.append(np.bincount(bodies[samples.triangles], samples.areas_m2 * strict, len(is_closed)))
        kept.append((free_m > step_m) & _air_near(room, begins + step_m * towards) | strict)
    surveyed = np.array([name != NOT_SURVEYED for name in mesh.names])[mesh.part[near]]
    kept = [each & surveyed[samples.triangles] for each in kept]
    kept[1] &= ~np.array([is_mapped(name) for name in mesh.names])[mesh.part[near]][samples.triangles]
    for side, other in ((0, 1), (1, 0)):
        loses = is_closed & (votes[side] < votes[other] + (side == 1) * 1e-12)
        kept[side] &= ~loses[bodies[samples.triangles]]
    parts = [samples.triangles[side] for side in kept]
    if not sum(map(len, parts)):
        raise SurveyError("No surface is in the air that the UAV reaches from its home.")
    return SurfacePoints(
        np.concatenate([samples.points_m[side] for side in kept]),
        np.concatenate([normals[parts[0]], -normals[parts[1]]]),
        np.concatenate([samples.areas_m2[side] for side in kept]),
        np.concatenate([mesh.part[near][part] for part in parts]),
    )


def _air_near(room: Room, places_m: np.ndarray) -> np.ndarray:
    """Return which places (n,) have air in their voxel or in one of the six beside it."""
    found = room.at(room.air, places_m) > 0
    for axis in range(3):
        for sign in (-1.0, 1.0):
            missing = ~found
            shifted = places_m[missing] + sign * room.voxel_m * np.eye(3)[axis]
            found[missing] = room.at(room.air, shifted) > 0
    return found
