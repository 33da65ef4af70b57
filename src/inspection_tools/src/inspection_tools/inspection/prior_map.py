"""What is known of a place before the flight, by its drawing: it fills what the lidar has not seen yet."""

from __future__ import annotations

import numpy as np

from inspection_tools.planning import FREE, UNKNOWN
from inspection_tools.survey.surface.room import AIR, Room


class PriorMap:
    """The air of a room, as voxels of another size.

    What the drawing shows as air counts as free until the lidar has seen it. Nothing else is known of it. So
    a surface of the drawing blocks until the lidar sees that it is not there.

    Args:
        room: in the map's frame.
    """

    def __init__(self, room: Room) -> None:
        self._room = room

    def tiles(self, resolution_m: float, side: int) -> np.ndarray:
        """Return (n, 3) the tiles that the room reaches into, counted from the frame's origin."""
        shape = np.array(self._room.air.shape[::-1])
        low = np.floor(self._room.corner_m / (resolution_m * side)).astype(np.int64)
        high_m = self._room.corner_m + shape * self._room.voxel_m
        high = np.ceil(high_m / (resolution_m * side)).astype(np.int64)
        axes = [np.arange(a, b) for a, b in zip(low, high)]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)

    def filled(self, resolution_m: float, side: int, tiles: np.ndarray, voxels: np.ndarray) -> np.ndarray:
        """Return voxels (n, side**3), as `VoxelGrid.update` takes them, with what the drawing knows."""
        filled = voxels.copy()
        for tile, cube in zip(tiles, filled):
            unknown = np.flatnonzero(cube == UNKNOWN)
            if len(unknown):
                index = np.column_stack(np.unravel_index(unknown, (side,) * 3))[:, ::-1]
                free = self._is_air((tile * side + index + 0.5) * resolution_m, resolution_m)
                cube[unknown[free]] = FREE
        return filled

    def _is_air(self, centres_m: np.ndarray, side_m: float) -> np.ndarray:
        """Return (n,) which cubes hold air only."""
        steps = max(2, int(np.ceil(side_m / self._room.voxel_m)))
        offsets = ((np.arange(steps) + 0.5) / steps - 0.5) * side_m
        is_air = np.ones(len(centres_m), bool)
        for offset in np.stack(np.meshgrid(offsets, offsets, offsets), axis=-1).reshape(-1, 3):
            is_air &= self._room.at(self._room.air, centres_m + offset) == AIR
        return is_air
