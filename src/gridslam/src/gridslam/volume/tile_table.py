"""Which tile is at which place: a table that grows in any direction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gridslam.errors import MapError
from gridslam.volume.kernels.tiles import SIDE, UNSEEN

ROOM = 8
"""Extra tiles on each side when the table grows."""
PLACES_MAX = 1 << 26
"""Of a table."""


class Box(NamedTuple):
    """Voxels from low (3,) to below high (3,), x, y, z, counted from the map's origin."""

    low: np.ndarray
    high: np.ndarray


class TileTable:
    """Indices of tiles by place. Voxels are cubes of a side, aligned to the map's origin."""

    def __init__(self, resolution_m: float):
        self.resolution_m = resolution_m
        self.table = np.zeros((0, 0, 0), np.int32)
        """(d, h, w) tile of each place: z, y, x."""
        self.corner = np.zeros(3, np.int64)
        """Tile of the table's first place, x, y, z, from the map's origin."""
        self._outside = UNSEEN

    def cover(self, low: np.ndarray, high: np.ndarray) -> None:
        """Let the table cover the tiles from low (3,) to below high (3,), x, y, z.

        Raises:
            MapError: the table would be too large.
        """
        size = np.array(self.table.shape[::-1])
        end = self.corner + size
        if size.all() and (low >= self.corner).all() and (high <= end).all():
            return
        if not size.all():
            new_low, new_high = low - ROOM, high + ROOM
        else:
            new_low = np.where(low < self.corner, low - ROOM, self.corner)
            new_high = np.where(high > end, high + ROOM, end)
        shape = (new_high - new_low)[::-1]
        if np.prod(shape.astype(float)) > PLACES_MAX:
            extent = " x ".join(f"{side * SIDE * self.resolution_m:.0f}" for side in shape[::-1])
            raise MapError(
                f"The map would grow to {extent} m, too large for voxels of {self.resolution_m} "
                "m; check the transforms, cut the rays with max_range, or choose a larger resolution."
            )
        table = np.full(shape, self._outside, np.int32)
        if size.all():
            x, y, z = (int(value) for value in self.corner - new_low)
            depth, height, width = self.table.shape
            table[z : z + depth, y : y + height, x : x + width] = self.table
        self.table, self.corner = table, np.asarray(new_low, np.int64).copy()

    def known_places(self) -> np.ndarray:
        """Return the places (n, 3) in the table, z, y, x, that have a tile; in the table's order."""
        return np.argwhere(self.table > UNSEEN)

    def box(self) -> Box:
        """Return the box of all tiles; without any it is empty."""
        places = self.known_places()[:, ::-1]
        if not len(places):
            return Box(np.zeros(3, np.int64), np.zeros(3, np.int64))
        low, high = places.min(axis=0) + self.corner, places.max(axis=0) + 1 + self.corner
        return Box(low * SIDE, high * SIDE)

    def known_tiles(self) -> np.ndarray:
        """Return the tiles (n, 3), x, y, z from the map's origin, that there are."""
        return self.known_places()[:, ::-1] + self.corner

    def indices(self, tiles: np.ndarray) -> np.ndarray:
        """Return the indices (n,) of tiles (n, 3), x, y, z; UNSEEN where there is none."""
        inside = tiles - self.corner
        are_inside = ((inside >= 0) & (inside < self.table.shape[::-1])).all(axis=1)
        found = np.full(len(tiles), UNSEEN, np.int32)
        found[are_inside] = np.maximum(self.table[tuple(inside[are_inside, ::-1].T)], UNSEEN)
        return found


def dense_of(table: TileTable, cubes: np.ndarray, box: Box) -> np.ndarray:
    """Return the voxels (d, h, w) of a box from the cubes (tiles, VOXELS) of a table's tiles."""
    low, high = np.asarray(box.low) // SIDE, -(-np.asarray(box.high) // SIDE)
    size = np.maximum(high - low, 0)[::-1]
    tiles = np.stack(np.meshgrid(*(np.arange(n) for n in size), indexing="ij"), axis=-1).reshape(-1, 3)
    found = cubes[table.indices(tiles[:, ::-1] + low)].reshape(*size, SIDE, SIDE, SIDE)
    dense = found.transpose(0, 3, 1, 4, 2, 5).reshape(size * SIDE)
    first = (np.asarray(box.low) - low * SIDE)[::-1]
    last = first + (np.asarray(box.high) - np.asarray(box.low))[::-1]
    return dense[first[0] : last[0], first[1] : last[1], first[2] : last[2]].copy()
