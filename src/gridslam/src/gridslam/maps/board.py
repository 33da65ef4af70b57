"""The scratch memory in which beams are counted before they are entered into tiles."""

from __future__ import annotations

import numpy as np

from gridslam.kernels.insertion import BeamEnds
from gridslam.kernels.tiles import SIDE


class Board:
    """Grows to the longest beams. All particles use it in turn."""

    def __init__(self) -> None:
        self._counts = np.zeros(0, np.uint8)
        self._flags = np.zeros((3, 0), bool)
        self.tables = np.zeros(0, np.int32)
        """A tile index for each of the board's tiles."""

    def reserve(self, reach: float) -> None:
        """Make room for beams of this many cells at any heading."""
        tiles = int(2.0 * reach / SIDE + 4.0) ** 2
        if self.tables.size < tiles:
            self._counts, self.tables = np.zeros(tiles * SIDE**2, np.uint8), np.zeros(tiles, np.int32)
            self._flags = np.zeros((3, tiles), bool)

    def ends(self, points: np.ndarray, hits: np.ndarray) -> BeamEnds:
        """Return the kernels' input for a scan: the lidar and its beams' ends (n + 1, 2), and hits (n,)."""
        return BeamEnds(points, hits, np.empty_like(points), self._counts, *self._flags)
