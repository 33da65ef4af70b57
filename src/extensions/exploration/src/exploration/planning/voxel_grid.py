"""A map of voxels that grows tile by tile."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_basics.errors import MapError

UNKNOWN, FREE, OCCUPIED = 0, 1, 2
MOST_VOXELS = 200_000_000
"""Of the box around all tiles."""
FARTHEST_TILE = 1_000_000


@dataclass(frozen=True)
class AssumedFree:
    """Voxels that were assumed to be free.

    low, high: (3,) x, y, z, from and before. is_new: (d, h, w), z first.
    """

    low: np.ndarray
    high: np.ndarray
    is_new: np.ndarray


class VoxelGrid:
    """Kinds of voxels in the box around all tiles that were given. Outside it all is unknown.

    Voxel (i, j, k) reaches from (i, j, k) * resolution_m to (i + 1, j + 1, k + 1) * resolution_m.

    Attributes:
        resolution_m: side of a voxel. side: voxels along a tile.
        corner: (3,) x, y, z of the first voxel. kinds: (d, h, w), z first: UNKNOWN, FREE or OCCUPIED.
        is_assumed_free: (d, h, w) where UNKNOWN counts as FREE.
        versions: (d, h, w) of tiles, z first: how often each has changed. known: voxels that are not UNKNOWN.

    Raises:
        MapError: the resolution or the side is not positive.
    """

    def __init__(self, resolution_m: float, side: int):
        if not 0.0 < resolution_m < np.inf or not 0 < side <= 256:
            raise MapError(f"A map with voxels of {resolution_m} m in tiles of {side} makes no sense.")
        self.resolution_m, self.side = resolution_m, side
        self.corner = np.zeros(3, np.int64)
        self.kinds = np.zeros((0, 0, 0), np.uint8)
        self.is_assumed_free = np.zeros((0, 0, 0), bool)
        self.versions = np.zeros((0, 0, 0), np.int64)
        self.known = 0

    def update(self, tiles: np.ndarray, voxels: np.ndarray) -> np.ndarray:
        """Take over tiles. Return which of them (n,) have changed.

        Args:
            tiles: (n, 3) x, y, z, counted in tiles from the frame's origin.
            voxels: (n, side**3) kinds, x fastest, then y.

        Raises:
            MapError: the numbers do not agree, a kind is unknown, or the tiles are too far apart. The map
                stays as it was.
        """
        tiles, voxels = np.asarray(tiles, np.int64), np.asarray(voxels, np.uint8)
        if tiles.ndim != 2 or tiles.shape[1] != 3 or voxels.shape != (len(tiles), self.side**3):
            raise MapError(f"{tiles.size / 3:g} tiles of {self.side}^3 voxels do not come as {voxels.size}.")
        if voxels.max(initial=0) > OCCUPIED:
            raise MapError(
                f"A voxel is {voxels.max()}, but only 0 to 2 (unknown, free, occupied) have a meaning."
            )
        if np.abs(tiles).max(initial=0) > FARTHEST_TILE:
            raise MapError("A tile is farther from the origin than any map reaches.")
        has_changed = np.zeros(len(tiles), bool)
        if not len(tiles):
            return has_changed
        self._cover(tiles.min(axis=0) * self.side, (tiles.max(axis=0) + 1) * self.side)
        side = self.side
        for n, (x, y, z) in enumerate((tiles * side - self.corner).tolist()):
            part = self.kinds[z : z + side, y : y + side, x : x + side]
            cube = voxels[n].reshape(part.shape)
            has_changed[n] = (part != cube).any()
            if has_changed[n]:
                self.known += int(np.count_nonzero(cube)) - int(np.count_nonzero(part))
                self.versions[z // side, y // side, x // side] += 1
                part[...] = cube
        return has_changed

    def _cover(self, low: np.ndarray, high: np.ndarray) -> None:
        """Grow to hold the voxels from low to before high, x, y, z."""
        if self.kinds.size:
            low = np.minimum(low, self.corner)
            high = np.maximum(high, self.corner + self.shape_xyz)
        if (low == self.corner).all() and (high - low == self.shape_xyz).all():
            return
        size = high - low
        if np.prod(size.astype(float)) > MOST_VOXELS:
            raise MapError(
                f"The tiles span {' x '.join(map(str, size.tolist()))} voxels, too many for a plan."
            )
        old = placed(self.corner - low, self.kinds.shape)
        kinds, is_assumed_free = np.zeros(size[::-1], np.uint8), np.zeros(size[::-1], bool)
        kinds[old], is_assumed_free[old] = self.kinds, self.is_assumed_free
        versions = np.zeros(size[::-1] // self.side, np.int64)
        versions[placed((self.corner - low) // self.side, self.versions.shape)] = self.versions
        self.corner, self.kinds, self.is_assumed_free, self.versions = low, kinds, is_assumed_free, versions

    def assume_free(self, place_m: np.ndarray, radius_m: float) -> AssumedFree | None:
        """Let unknown voxels count as free whose centres are in a ball around a place (x, y, z).

        Returns:
            What is new; None if nothing is.
        """
        centre = np.asarray(place_m) / self.resolution_m
        reach = radius_m / self.resolution_m
        low, high = np.floor(centre - reach).astype(np.int64), np.ceil(centre + reach).astype(np.int64)
        self._cover(low // self.side * self.side, -(-high // self.side) * self.side)
        part = placed(low - self.corner, tuple((high - low)[::-1]))
        axes = [(np.arange(a, b) + 0.5 - c) ** 2 for a, b, c in zip(low, high, centre)][::-1]
        is_inside = axes[0][:, None, None] + axes[1][:, None] + axes[2] <= reach**2
        is_new = is_inside & ~self.is_assumed_free[part]
        if not is_new.any():
            return None
        self.is_assumed_free[part] |= is_new
        return AssumedFree(low, high, is_new)

    def withdraw(self, assumed: AssumedFree) -> None:
        """Let voxels that were assumed to be free count as what they are."""
        self.is_assumed_free[placed(assumed.low - self.corner, assumed.is_new.shape)] &= ~assumed.is_new

    def is_free(self, part: tuple[slice, ...] | tuple[int, int, int]) -> np.ndarray:
        """Return which voxels of a part (z, y, x) are free, or assumed to be free."""
        kinds = self.kinds[part]
        return (kinds == FREE) | ((kinds == UNKNOWN) & self.is_assumed_free[part])

    @property
    def shape_xyz(self) -> np.ndarray:
        """(3,) voxels along x, y and z."""
        return np.array(self.kinds.shape[::-1], np.int64)

    def index_of(self, place_m: np.ndarray) -> tuple[int, int, int] | None:
        """Return z, y, x of the voxel that holds a place (x, y, z); None if it is outside."""
        voxel = np.floor(np.asarray(place_m) / self.resolution_m).astype(np.int64) - self.corner
        if (voxel < 0).any() or (voxel >= self.shape_xyz).any():
            return None
        return tuple(voxel[::-1].tolist())

    def centres_m(self, indices: np.ndarray) -> np.ndarray:
        """Return the centres (n, 3), x, y, z, of voxels (n, 3), z, y, x."""
        return (indices[:, ::-1] + self.corner + 0.5) * self.resolution_m


def placed(at_xyz: np.ndarray, shape: tuple[int, ...]) -> tuple[slice, ...]:
    """Return the slices (z, y, x) where an array of this shape stands whose first voxel is at x, y, z."""
    return tuple(slice(at, at + size) for at, size in zip(at_xyz[::-1].tolist(), shape))
