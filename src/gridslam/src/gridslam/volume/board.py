"""The scratch memory on which the rays of a cloud are marked, one bit a voxel."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gridslam.errors import MapError
from gridslam.maps.mapped_arrays import mapped_zeros
from gridslam.volume.kernels.insertion import PER_WORD
from gridslam.volume.kernels.rays import CUT, HIT, LEFT_OUT, clear_ends, end_rays, mark_ends, mark_rays
from gridslam.volume.kernels.tiles import KEY_MAX, SIDE, SIDE_BITS

BYTES_MAX = 1 << 29
"""Of a board. Only the parts that rays cross take memory."""


class Rays(NamedTuple):
    """The rays of one cloud, and the box of voxels that holds them."""

    origin: np.ndarray
    """(3,) float32 of the sensor in the map's frame."""
    ends: np.ndarray
    """(n, 3) float32 there."""
    kinds: np.ndarray
    """(n,) uint8: LEFT_OUT, CUT or HIT."""
    low: np.ndarray
    """(3,) least tile that the rays, rounded anyhow, reach."""
    shape: np.ndarray
    """(3,) tiles from there on, along x, y, z; along x they fill words."""


class Board:
    """Grows to the largest cloud; afterwards it is always empty."""

    def __init__(self) -> None:
        self.misses, self.hits = mapped_zeros((1,), np.uint64), mapped_zeros((1,), np.uint64)

    def mark(self, rays: Rays, resolution_m: float) -> None:
        """Mark the voxels that rays cross, and those in which they end.

        Raises:
            MapError: the rays are too long for voxels of this size.
        """
        self._reserve(rays)
        corner, stride = rays.low << SIDE_BITS, stride_of(rays.shape)
        given = (rays.ends, rays.kinds, HIT, 1.0 / resolution_m, corner, stride)
        mark_ends(*given, self.hits, np.empty(len(rays.ends), bool))
        mark_rays(rays.ends, rays.kinds, rays.origin, resolution_m, corner, stride, self.misses)

    def thinned(self, rays: Rays, resolution_m: float) -> np.ndarray:
        """Return which rays (n,) are the first of their kind that end in their voxel.

        Raises:
            MapError: as `mark`.
        """
        self._reserve(rays)
        are_first = np.zeros(len(rays.ends), bool)
        corner, stride = rays.low << SIDE_BITS, stride_of(rays.shape)
        for kind in (HIT, CUT):
            given = (rays.ends, rays.kinds, kind, 1.0 / resolution_m, corner, stride, self.hits)
            mark_ends(*given, are_first)
            clear_ends(*given)
        return are_first

    def _reserve(self, rays: Rays) -> None:
        words = int(np.prod(rays.shape)) * SIDE**3 // 64
        if words * 8 > BYTES_MAX:
            extent = ", ".join(f"{side * SIDE}" for side in rays.shape)
            raise MapError(
                f"A cloud of {extent} voxels is too large; cut its rays with max_range, or choose a larger "
                "resolution."
            )
        if self.misses.size < words:
            self.misses, self.hits = mapped_zeros((words,), np.uint64), mapped_zeros((words,), np.uint64)


def stride_of(shape: np.ndarray) -> np.ndarray:
    """Return the bits (3,) from a voxel to the next along x, y and z, on a board of so many tiles (3,)."""
    width, depth = int(shape[0]) * SIDE, int(shape[1]) * SIDE
    return np.array((1, width, width * depth))


def rays_of(origin: np.ndarray, points: np.ndarray, resolution_m: float, max_range_m: float) -> Rays:
    """Return the rays from an origin (3,) to points (n, 3), both float32 in the map's frame.

    Points that are not finite, or outside an octree's 65,536 voxels a side, are left out.

    Raises:
        MapError: the origin is outside these.
    """
    voxel = np.floor(origin.astype(float) / resolution_m)
    if not (np.abs(voxel) < KEY_MAX).all():
        raise MapError(
            f"The sensor is at {np.array2string(origin, precision=1)} m, farther than {KEY_MAX} voxels of "
            f"{resolution_m} m from the map's origin; check the transforms, or choose a larger resolution."
        )
    low = voxel.astype(np.int64)
    high, ends, kinds = low.copy(), np.empty_like(points), np.full(len(points), LEFT_OUT, np.uint8)
    end_rays(points, origin, 1.0 / resolution_m, max_range_m, ends, kinds, low, high)
    low_tile, high_tile = (low - 1) >> SIDE_BITS, (high + 1) >> SIDE_BITS
    shape = high_tile + 1 - low_tile
    shape[0] = -(-shape[0] // PER_WORD) * PER_WORD
    return Rays(origin, ends, kinds, low_tile, shape)
