"""How much of the world's own room the map of an exploration knows: also what the UAV is too wide for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from gridslam.evaluation.volume.surface import Surface
from gridslam.volume.drawing.centres import free_centres, occupied_centres
from gridslam.volume.voxel_map import VoxelMap

NARROWEST_M = 0.3
"""Rooms belong together if an opening of about this width joins them."""
LARGEST_M = 300.0
"""Something larger is the ground, not the place."""
VOXELS_MAX = 30_000_000
SIDE_M = 0.5 * NARROWEST_M / 1.5
"""Of the voxels: one on each side of a place's own leaves an opening of the least width."""
SAMPLES = 2
"""Of the surface along a voxel's side. A wall leaks only where nine neighbours have none of their four."""
AROUND = np.ones((3, 3, 3), bool)


@dataclass(frozen=True)
class WorldShare:
    """room_m3: of all rooms that are joined with the one where the UAV was. known_share: on the map, 0..1."""

    room_m3: float
    known_share: float


def known_centres(voxels: VoxelMap) -> np.ndarray:
    """Return the centres (n, 3) of all voxels of a map that are free or occupied, m."""
    rng = np.random.default_rng(0)  # draws nothing: all are asked for
    return np.concatenate((occupied_centres(voxels), free_centres(voxels, 2**62, rng)))


def share_of_world(
    known_m: np.ndarray, voxel_m: float, surface: Surface, begin_m: np.ndarray, rng: np.random.Generator
) -> WorldShare | None:
    """Return it; None if the place is open to its sides, or too large, or the UAV was inside of something.

    known_m: (n, 3) centres of the map's known voxels, whose side is voxel_m, in `world`. begin_m: (x, y, z)
    of a place where the UAV was. rng: draws samples of the surface. An open top counts as closed at the
    height of what is highest.
    """
    low_m, high_m = _extent_m(surface)
    shape = np.ceil((high_m - low_m) / SIDE_M).astype(int)[::-1]
    begin = np.floor((begin_m - low_m) / SIDE_M).astype(int)[::-1]
    if shape.prod() > VOXELS_MAX or (begin < 0).any() or (begin >= shape).any():
        return None
    blocked = np.zeros(shape, bool)
    points_m = surface.samples(SIDE_M / SAMPLES, rng, low_m, high_m).points_m
    blocked[_voxels_at(points_m, low_m, shape)] = True
    labels, _ = ndimage.label(~ndimage.binary_dilation(blocked, AROUND))
    if not labels[tuple(begin)]:
        return None
    middles = labels == labels[tuple(begin)]
    if any(middles[side].any() for side in ((slice(None), (0, -1)), (slice(None), slice(None), (0, -1)))):
        return None
    room = ndimage.binary_dilation(middles, AROUND) & ~blocked
    return WorldShare(
        float(room.sum()) * SIDE_M**3, float(_known(known_m, voxel_m, low_m, shape)[room].mean())
    )


def _extent_m(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and highest corner of all but the ground."""
    corners = surface.triangles_m.reshape(-1, 3)
    lows, highs = [], []
    for part in range(len(surface.names)):
        own = corners[np.repeat(surface.part == part, 3)]
        low_m, high_m = own.min(axis=0), own.max(axis=0)
        if (high_m - low_m).max() < LARGEST_M:
            lows.append(low_m)
            highs.append(high_m)
    if not lows:
        return np.zeros(3), np.zeros(3)
    return np.min(lows, axis=0) - SIDE_M, np.max(highs, axis=0) + SIDE_M


def _known(known_m: np.ndarray, side_m: float, low_m: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Return (d, h, w) which voxels' centres lie in a known voxel of the map."""
    lowest = np.floor(low_m / side_m).astype(int)
    size = np.floor((low_m + shape[::-1] * SIDE_M) / side_m).astype(int) + 1 - lowest
    coarse = np.zeros(size[::-1], bool)
    at = np.floor(known_m / side_m).astype(int) - lowest
    at = at[((at >= 0) & (at < size)).all(axis=1)]
    coarse[tuple(at[:, ::-1].T)] = True
    x, y, z = (
        np.floor((low + (np.arange(n) + 0.5) * SIDE_M) / side_m).astype(int) - first
        for low, n, first in zip(low_m, shape[::-1], lowest)
    )
    known: np.ndarray = coarse[np.ix_(z, y, x)]
    return known


def _voxels_at(points_m: np.ndarray, low_m: np.ndarray, shape: np.ndarray) -> tuple[np.ndarray, ...]:
    index = np.floor((points_m - low_m) / SIDE_M).astype(int)[:, ::-1]
    return tuple(np.clip(index, 0, shape - 1).T)
