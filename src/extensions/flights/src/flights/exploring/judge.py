"""Judges what an exploration knows by the world's own surfaces, on a grid that is not the planner's."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from gridslam.evaluation.volume.surface import Surface, read_surface
from gridslam.evaluation.volume.visibility import LidarView, Places, visible_samples
from gridslam.volume import ShownMap
from gridslam.volume.shown_map import OCCUPIED, UNKNOWN
from gridslam.volume.tile_table import Box

SIDE_M = 0.05
"""Of the judge's voxels."""
SAMPLE_M, SURFACE_M = 0.025, 0.1
"""One point of the surfaces for each square of this side: for what is blocked, and for what is mapped."""
PLACES_M = 1.0
"""Between places from which the surface could be seen."""
SLAB = 40
"""Layers whose distances are computed at once: more would need memory in proportion."""


@dataclass(frozen=True)
class Judged:
    """What could be known, and what is. Shares are 0..1.

    reachable_m3: all that a ball of the clearance's radius can fill from where the UAV was. visible_m2: the
    surface that the lidar, level, could see from where the ball's centre can be.
    """

    reachable_m3: float
    known_share: float
    visible_m2: float
    mapped_share: float


def judge_map(
    shown: ShownMap,
    world: Path | Surface,
    box_m: tuple[tuple[float, ...], tuple[float, ...]],
    begin_m: np.ndarray,
    clearance_m: float,
    view: LidarView,
    rng: np.random.Generator,
) -> Judged:
    """Compare a map with the world that it shows. Their frames agree.

    Args:
        shown: the map.
        world: its file, or its surfaces.
        box_m: lowest and highest corner of what is judged, x, y, z. What the map lacks in it is missing.
        begin_m: (x, y, z) of a place where the UAV was.
        clearance_m: that the UAV keeps.
        view: of the lidar.
        rng: draws samples of the surfaces.

    Raises:
        EvaluationError: the world cannot be read.
        ValueError: the place has no such clearance.
    """
    surface = world if isinstance(world, Surface) else read_surface(world)
    low_m, high_m = np.array(box_m[0]), np.array(box_m[1])
    centres = room_of(surface, box_m, begin_m, clearance_m, rng)
    filled = _nearer(centres, clearance_m)
    is_known = _kinds_at(shown, low_m, filled.shape) != UNKNOWN
    places_m = _thinned(low_m + (np.argwhere(centres[::4, ::4, ::4])[:, ::-1] * 4 + 0.5) * SIDE_M)
    samples = surface.samples(SURFACE_M, rng, low_m, high_m)
    level = Places(places_m, np.broadcast_to(np.eye(3), (len(places_m), 3, 3)))
    seen_m = samples.points_m[visible_samples(surface, samples, level, view, rng)]
    reach_m = 1.5 * shown.resolution_m
    apart_m, _ = cKDTree(shown.centres(OCCUPIED)).query(seen_m, p=np.inf, distance_upper_bound=reach_m + 1e-9)
    return Judged(
        reachable_m3=float(filled.sum()) * SIDE_M**3,
        known_share=float((filled & is_known).sum() / max(filled.sum(), 1)),
        visible_m2=len(seen_m) * SURFACE_M**2,
        mapped_share=float((apart_m <= reach_m).mean()) if len(seen_m) else math.nan,
    )


def room_of(
    surface: Surface,
    box_m: tuple[tuple[float, ...], tuple[float, ...]],
    begin_m: np.ndarray,
    clearance_m: float,
    rng: np.random.Generator,
) -> np.ndarray:
    """Return (d, h, w) the voxels of SIDE_M, from the lowest corner, where the UAV's centre can come to.

    Arguments and errors as of `judge_map`.
    """
    low_m, high_m = np.array(box_m[0]), np.array(box_m[1])
    blocked = _blocked(surface, low_m, high_m, rng)
    return _reached(blocked, np.floor((begin_m - low_m) / SIDE_M).astype(int), clearance_m)


def _blocked(surface: Surface, low_m: np.ndarray, high_m: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return (d, h, w) the voxels that the surface meets."""
    shape = np.ceil((high_m - low_m) / SIDE_M).astype(int)[::-1]
    blocked = np.zeros(shape, bool)
    points_m = surface.samples(SAMPLE_M, rng, low_m, high_m).points_m
    index = np.floor((points_m - low_m) / SIDE_M).astype(int)[:, ::-1]
    blocked[tuple(np.clip(index, 0, shape - 1).T)] = True
    return blocked


def _reached(blocked: np.ndarray, begin: np.ndarray, clearance_m: float) -> np.ndarray:
    """Return (d, h, w) where the centre of the UAV can be. begin: (3,) x, y, z.

    Raises:
        ValueError: it cannot begin there.
    """
    labels, _ = ndimage.label(~_nearer(blocked, clearance_m), np.ones((3, 3, 3), bool))
    label = labels[tuple(begin[::-1])]
    if label == 0:
        raise ValueError(f"The UAV does not have {clearance_m} m to each side where it begins.")
    reached: np.ndarray = labels == label
    return reached


def _nearer(marked: np.ndarray, radius_m: float) -> np.ndarray:
    """Return (d, h, w) which voxels' centres are nearer than a radius to that of a marked one."""
    reach = math.ceil(radius_m / SIDE_M)
    near = np.empty(marked.shape, bool)
    for first in range(0, len(marked), SLAB):
        low, last = max(first - reach, 0), first + SLAB
        part = marked[low : last + reach]
        apart = ndimage.distance_transform_edt(~part) if part.any() else np.full(part.shape, np.inf)
        near[first:last] = apart[first - low : first - low + SLAB] * SIDE_M < radius_m
    return near


def _kinds_at(shown: ShownMap, low_m: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return (d, h, w) the kinds that the map shows at the centres of the judge's voxels."""
    indices = [
        np.floor((low + (np.arange(size) + 0.5) * SIDE_M) / shown.resolution_m).astype(np.int64)
        for low, size in zip(low_m, shape[::-1])
    ]
    low = np.array([index[0] for index in indices])
    kinds = shown.dense(Box(low, np.array([index[-1] + 1 for index in indices])))
    x, y, z = (index - first for index, first in zip(indices, low))
    at: np.ndarray = kinds[np.ix_(z, y, x)]
    return at


def _thinned(places_m: np.ndarray) -> np.ndarray:
    """Return one of the places (n, 3) in each cube."""
    _, first = np.unique(np.floor(places_m / PLACES_M).astype(np.int64), axis=0, return_index=True)
    return places_m[first]
