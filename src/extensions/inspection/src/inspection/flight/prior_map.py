"""What is known of a place before the flight, by its drawing: it fills what the lidar has not seen yet."""

from __future__ import annotations

import numpy as np

from exploration.planning import FREE, UNKNOWN
from inspection.survey.surface.room import AIR, Room


class PriorMap:
    """The air of a room, as voxels of another size.

    What the drawing shows as air counts as free until the lidar has seen it. Nothing else is known of it. So
    a surface of the drawing blocks until the lidar sees that it is not there.

    Args:
        room: in the map's frame.
    """

    def __init__(self, room: Room) -> None:
        self._room = room
        self._drawn: tuple[tuple[float, int], np.ndarray, np.ndarray] | None = None

    def tiles(self, resolution_m: float, side: int) -> np.ndarray:
        """Return (n, 3) the tiles that the room reaches into, counted from the frame's origin."""
        first, is_air = self._air(resolution_m, side)
        axes = [np.arange(low, low + size // side) for low, size in zip(first, is_air.shape[::-1])]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)

    def filled(self, resolution_m: float, side: int, tiles: np.ndarray, voxels: np.ndarray) -> np.ndarray:
        """Return voxels (n, side**3), as `VoxelGrid.update` takes them, with what the drawing knows."""
        first, is_air = self._air(resolution_m, side)
        filled = voxels.copy()
        for tile, cube in zip(tiles, filled):
            x, y, z = (side * (tile - first)).tolist()
            if min(x, y, z) >= 0:
                drawn = is_air[z : z + side, y : y + side, x : x + side].ravel()
                if len(drawn):  # else it is beyond the room
                    cube[(cube == UNKNOWN) & drawn] = FREE
        return filled

    def _air(self, resolution_m: float, side: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the first tile, x, y, z, and (d, h, w) which voxels hold air only, in whole tiles."""
        if self._drawn is None or self._drawn[0] != (resolution_m, side):
            room = self._room
            tile_m = resolution_m * side
            high_m = room.corner_m + np.array(room.air.shape[::-1]) * room.voxel_m
            first = np.floor(room.corner_m / tile_m).astype(np.int64)
            last = np.ceil(high_m / tile_m).astype(np.int64)
            steps = max(2, int(np.ceil(resolution_m / room.voxel_m)))
            padded = np.pad(room.air == AIR, 1)
            is_air = np.ones((side * (last - first))[::-1], bool)
            for shares in np.ndindex(steps, steps, steps):
                index = [
                    _inner(side * low, side * high, (share + 0.5) / steps, resolution_m, corner_m, room, size)
                    for low, high, share, corner_m, size in zip(
                        first, last, shares, room.corner_m, room.air.shape[::-1]
                    )
                ]
                is_air &= padded[np.ix_(*index[::-1])]
            self._drawn = (resolution_m, side), first, is_air
        return self._drawn[1], self._drawn[2]


def _inner(
    low: int, high: int, share: float, resolution_m: float, corner_m: float, room: Room, size: int
) -> np.ndarray:
    """Return the padded room's index, along one axis, of places in voxels from low to before high."""
    places_m = (np.arange(low, high) + share) * resolution_m
    inner = np.floor((places_m - corner_m) / room.voxel_m).astype(np.int64)
    return np.clip(inner, -1, size) + 1
