"""The voxels of the oldest events, kept small: a correction that moves none of these begins behind them."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Callable, Sequence

import numpy as np

from gridslam.volume.board import Board
from gridslam.volume.correction.events import Event, insert_event
from gridslam.volume.kernels.tiles import ROWS, VOXELS
from gridslam.volume.parameters import VolumeParameters
from gridslam.volume.voxel_map import VoxelMap

AT_ONCE = 256
"""Tiles that are packed together: 4 MB."""
LEVEL = 1
"""zlib's fastest. A tile is mostly one value, so it takes a fiftieth all the same."""


@dataclass(frozen=True, eq=False)
class PackedVoxels:
    """A map of voxels that nobody reads at present."""

    parameters: VolumeParameters
    tiles: np.ndarray
    """(n, 3) x, y, z from the map's origin."""
    packed: tuple[bytes, ...]
    """Log-odds, then the rows of sure voxels, of `AT_ONCE` tiles each."""

    @classmethod
    def of(cls, voxels: VoxelMap) -> PackedVoxels:
        """Pack a map."""
        tiles, pool = voxels.known_tiles(), voxels.pool
        found = voxels.indices(tiles)
        parts = [found[first : first + AT_ONCE] for first in range(0, len(found), AT_ONCE)]
        packed = [
            zlib.compress(pool.cubes[part].tobytes() + pool.sure_rows[part].tobytes(), LEVEL)
            for part in parts
        ]
        return cls(voxels.parameters, tiles, tuple(packed))

    def unpacked(self) -> VoxelMap:
        """Return the map, which is the caller's."""
        voxels = VoxelMap(self.parameters)
        if not len(self.tiles):
            return voxels
        voxels.cover(self.tiles.min(axis=0), self.tiles.max(axis=0) + 1)
        taken = voxels.pool.take(len(self.tiles), voxels.stamp)
        voxels.table[tuple((self.tiles - voxels.corner)[:, ::-1].T)] = taken
        for number, packed in enumerate(self.packed):
            part = taken[number * AT_ONCE : (number + 1) * AT_ONCE]
            data = zlib.decompress(packed)
            count = len(part) * VOXELS
            voxels.pool.cubes[part] = np.frombuffer(data, np.float32, count).reshape(-1, VOXELS)
            rows = np.frombuffer(data, np.uint16, offset=4 * count)
            voxels.pool.sure_rows[part] = rows.reshape(-1, ROWS)
        return voxels


class SettledEvents:
    """The voxels of the oldest events of a map, or of none.

    Args:
        before: what older events, or an earlier map, have given.
        count: number of events that these hold.
    """

    def __init__(self, before: PackedVoxels, count: int = 0):
        self.voxels, self.count = before, count

    def enter(self, events: Sequence[Event], board: Board, goes_on: Callable[[], bool]) -> bool:
        """Enter the next events, clouds with their present poses. Return whether all are entered.

        goes_on: asked before each one; if not, the rest is left out.
        """
        if not events:
            return True
        voxels, entered = self.voxels.unpacked(), 0
        while entered < len(events) and goes_on():
            insert_event(voxels, events[entered], None, board)
            entered += 1
        self.voxels, self.count = PackedVoxels.of(voxels), self.count + entered
        return entered == len(events)
