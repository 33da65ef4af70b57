"""Why a flight stayed before its goal: the narrowest place of the widest way there, in the world itself."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from gridslam.evaluation.volume.surface import Surface

SIDE_M, COARSEST_M = 0.05, 0.2
"""Of the voxels, doubled until there are few enough. A width is at most two of them too small."""
SAMPLES = 3
"""Of the surface along a voxel's side."""
AROUND_M = 2.0
"""The way stays within a box about both places and so much more."""
VOXELS_MAX = 4_000_000
WIDEST_M = 3.0
"""A wider place is not narrow."""
TOUCHING = np.ones((3, 3, 3), bool)


SMALL_NEEDS_M = 0.6
"""Width from which on small_quad passes an opening (doc/own_tank.md)."""
KEPT_STEP_M = 0.01
BESIDE_BODY_M = 0.05
"""The least that an r_lb which is proposed leaves beside the body."""


@dataclass(frozen=True)
class Cushions:
    """What CEPA keeps, m. keep_m: r_lb, to each side. body_m: body_radius."""

    keep_m: float
    body_m: float


@dataclass(frozen=True)
class NarrowPlace:
    """place_m: (x, y, z). width_m: twice the room to each side there; 0: no way leads to the goal."""

    place_m: tuple[float, float, float]
    width_m: float


def narrowest_on_way(
    surface: Surface, here_m: np.ndarray, goal_m: np.ndarray, rng: np.random.Generator
) -> NarrowPlace | None:
    """Return it; None if the way is wide, or too long to look at.

    here_m, goal_m: (3,) x, y, z. rng: draws samples of the surface.
    """
    low_m, high_m = np.minimum(here_m, goal_m) - AROUND_M, np.maximum(here_m, goal_m) + AROUND_M
    side_m = SIDE_M
    while np.prod((high_m - low_m) / side_m) > VOXELS_MAX:
        side_m *= 2.0
    if side_m > COARSEST_M:
        return None
    shape = np.ceil((high_m - low_m) / side_m).astype(int)[::-1]
    here, goal = (tuple(np.floor((each - low_m) / side_m).astype(int)[::-1]) for each in (here_m, goal_m))
    points_m = surface.samples(side_m / SAMPLES, rng, low_m, high_m).points_m
    room_m = _room_m(points_m, low_m, shape, side_m)
    most = min(room_m[here], room_m[goal], WIDEST_M / 2)
    steps = np.unique(room_m[room_m <= most])[::-1]  # from wide to narrow
    first, last = 0, len(steps)  # the first step that joins both places is in this range
    while first < last:
        middle = (first + last) // 2
        joins = _joins(room_m >= max(steps[middle], side_m), here, goal)
        first, last = (first, middle) if joins else (middle + 1, last)
    if first == 0:
        return None  # nowhere narrower than at its ends
    if first == len(steps):
        return NarrowPlace(tuple(here_m.tolist()), 0.0)
    gate = _gate(room_m, float(steps[first]), here, goal)
    x, y, z = (low_m + (np.array(gate)[::-1] + 0.5) * side_m).tolist()
    return NarrowPlace((x, y, z), 2.0 * float(steps[first]))


def why_it_stayed(
    surface: Surface,
    here_m: np.ndarray,
    goal_m: np.ndarray,
    uav: Cushions,
    rng: np.random.Generator,
) -> str:
    """Return a sentence if the way is narrower than the avoidance's cushions, or there is none.

    Empty: neither. uav: what CEPA keeps. Other arguments as of `narrowest_on_way`.
    """
    narrow = narrowest_on_way(surface, here_m, goal_m, rng)
    if narrow is None or narrow.width_m >= 2.0 * uav.keep_m:
        return ""
    if narrow.width_m == 0.0:
        return " No way leads from there to the goal."
    at = ", ".join(f"{v:.1f}" for v in narrow.place_m)
    return (
        f" The way leads through an opening at ({at}) that is about {narrow.width_m:.1f} m wide, but CEPA "
        f"keeps {uav.keep_m:g} m (r_lb) to each side, and so needs {2.0 * uav.keep_m:.1f} m. "
        f"{what_passes(narrow.width_m, uav)}"
    )


def what_passes(width_m: float, uav: Cushions) -> str:
    """Return which smaller cushion, or which smaller UAV, an opening lets through."""
    keep_m = math.floor(width_m / (2.0 * KEPT_STEP_M) + 1e-6) * KEPT_STEP_M
    if keep_m >= uav.body_m + BESIDE_BODY_M:
        return (
            f"This UAV fits with a smaller cushion: `rosrun dynamic_reconfigure dynparam set /cepa r_lb "
            f"{keep_m:g}`."
        )
    if width_m >= SMALL_NEEDS_M - 2.0 * SIDE_M:  # so much too small a width may be
        return (
            f"This UAV is too wide for it: its body needs {2.0 * uav.body_m:.1f} m (body_radius). small_quad "
            f"needs {SMALL_NEEDS_M:g} m: explore.launch and inspection.launch fly it by model:=small_quad."
        )
    return f"No UAV of this workspace fits: even small_quad needs {SMALL_NEEDS_M:g} m."


def _room_m(points_m: np.ndarray, low_m: np.ndarray, shape: np.ndarray, side_m: float) -> np.ndarray:
    """Return (d, h, w) the distance of each voxel to the nearest one with a surface in it."""
    free = np.ones(shape, bool)
    index = np.floor((points_m - low_m) / side_m).astype(int)[:, ::-1]
    free[tuple(np.clip(index, 0, shape - 1).T)] = False
    if free.all():
        return np.full(shape, np.inf)
    room_m: np.ndarray = side_m * ndimage.distance_transform_edt(free)
    return room_m


def _joins(fits: np.ndarray, here: tuple[int, ...], goal: tuple[int, ...]) -> bool:
    labels, _ = ndimage.label(fits, TOUCHING)
    return bool(labels[here] and labels[here] == labels[goal])


def _gate(room_m: np.ndarray, width_m: float, here: tuple[int, ...], goal: tuple[int, ...]) -> np.ndarray:
    """Return a voxel (3,) where the widest way is narrowest: between what is wider on both sides."""
    wider, _ = ndimage.label(room_m > width_m, TOUCHING)
    bands, _ = ndimage.label(room_m == width_m, TOUCHING)
    sides = []
    for voxel in (here, goal):
        own = np.zeros(room_m.shape, bool)
        own[voxel] = True
        if wider[voxel]:
            own = wider == wider[voxel]
        sides.append(ndimage.binary_dilation(own, TOUCHING))
    joining = np.intersect1d(bands[sides[0]], bands[sides[1]])
    joining = joining[joining > 0]
    gates = np.argwhere(bands == joining[0]) if len(joining) else np.argwhere((bands > 0) & sides[0])
    if not len(gates):
        return np.array(here)
    middle: np.ndarray = gates[np.linalg.norm(gates - gates.mean(axis=0), axis=1).argmin()]
    return middle
