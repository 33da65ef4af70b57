"""Distances to what is not known to be free, kept up to date where the map changes."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from exploration.planning.kernels.distances import squared_clearances
from exploration.planning.voxel_grid import UNKNOWN, AssumedFree, VoxelGrid, placed
from flight_limits import KeepOutBox

BLOCK = 64
"""Voxels along the side of a block that is computed at once."""


class ClearanceMap:
    """Squared distance, in voxels, from each voxel's centre to that of the nearest blocked one.

    Voxels that are occupied, unknown, or meet a keep-out box are blocked; so is all outside the grid.

    Args:
        grid: the map. reach: voxels; greater distances are cut there. boxes: keep-out boxes.
    """

    def __init__(self, grid: VoxelGrid, reach: int, boxes: Sequence[KeepOutBox] = ()):
        self.grid, self.reach, self._boxes = grid, reach, tuple(boxes)
        self._corner = grid.corner
        self._squares = np.zeros((0, 0, 0), np.uint16)
        self._changed: list[tuple[np.ndarray, np.ndarray]] = []
        if grid.kinds.size:
            self._changed.append((grid.corner, grid.corner + grid.shape_xyz))

    def note(self, tiles: np.ndarray) -> None:
        """Remember that tiles (n, 3), x, y, z, of the grid have changed."""
        side = self.grid.side
        self._changed += [(tile * side, (tile + 1) * side) for tile in np.asarray(tiles, np.int64)]

    def keep_out(self, boxes: Sequence[KeepOutBox]) -> None:
        """Take other keep-out boxes."""
        for box in set(boxes) ^ set(self._boxes):
            self._changed.append(self._voxels_of(box))
        self._boxes = tuple(boxes)

    def _voxels_of(self, box: KeepOutBox) -> tuple[np.ndarray, np.ndarray]:
        """Return the voxels from and before, x, y, z, that a box meets."""
        corners = np.array((box.low_m, box.high_m)) / self.grid.resolution_m
        return np.floor(corners[0]).astype(np.int64), np.ceil(corners[1]).astype(np.int64)

    def assume_free(self, place_m: np.ndarray, radius_m: float) -> AssumedFree | None:
        """See `VoxelGrid.assume_free`."""
        assumed = self.grid.assume_free(place_m, radius_m)
        if assumed is not None and self._was_unknown(assumed):
            self._changed.append((assumed.low, assumed.high))
        return assumed

    def withdraw(self, assumed: AssumedFree) -> None:
        """See `VoxelGrid.withdraw`."""
        self.grid.withdraw(assumed)
        self._changed.append((assumed.low, assumed.high))

    def _was_unknown(self, assumed: AssumedFree) -> bool:
        part = self.grid.kinds[placed(assumed.low - self.grid.corner, assumed.is_new.shape)]
        return bool((assumed.is_new & (part == UNKNOWN)).any())

    def squares(self) -> np.ndarray:
        """Return the squared distances (d, h, w), z first, uint16, at most reach**2; 0: blocked."""
        grid = self.grid
        if self._squares.shape != grid.kinds.shape or (self._corner != grid.corner).any():
            squares = np.zeros(grid.kinds.shape, np.uint16)
            squares[placed(self._corner - grid.corner, self._squares.shape)] = self._squares
            self._corner, self._squares = grid.corner, squares
        if self._changed:
            for block in self._stale_blocks():
                self._renew(block)
            self._changed = []
        return self._squares

    def _stale_blocks(self) -> np.ndarray:
        """Return the blocks (n, 3), z, y, x, that a change may reach."""
        is_stale = np.zeros([-(-size // BLOCK) for size in self._squares.shape], bool)
        for low, high in self._changed:
            first = np.maximum(low - self._corner - self.reach, 0) // BLOCK
            last = (high - self._corner + self.reach - 1) // BLOCK
            is_stale[tuple(slice(a, b + 1) for a, b in zip(first[::-1].tolist(), last[::-1].tolist()))] = True
        return np.argwhere(is_stale)

    def _renew(self, block: np.ndarray) -> None:
        low = block * BLOCK
        high = np.minimum(low + BLOCK, self._squares.shape)
        around = squared_clearances(self._blocked(low - self.reach, high + self.reach), self.reach)
        inner = tuple(slice(self.reach, self.reach + size) for size in (high - low).tolist())
        self._squares[tuple(map(slice, low.tolist(), high.tolist()))] = around[inner]

    def _blocked(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Return which voxels from low to before high, z, y, x in the grid, are blocked."""
        blocked = np.ones(high - low, bool)
        first, last = np.maximum(low, 0), np.minimum(high, self._squares.shape)
        inside = tuple(map(slice, (first - low).tolist(), (last - low).tolist()))
        blocked[inside] = ~self.grid.is_free(tuple(map(slice, first.tolist(), last.tolist())))
        for box in self._boxes:
            begin, end = (np.maximum((each - self._corner)[::-1] - low, 0) for each in self._voxels_of(box))
            blocked[tuple(map(slice, begin.tolist(), end.tolist()))] = True
        return blocked
