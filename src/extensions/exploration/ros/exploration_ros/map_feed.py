"""Passes the map of `slam_octomap` on to a planner."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from exploration.planning import PathPlanner
from exploration_ros import planner_messages
from flight_basics.errors import PoseError

QUEUE = 500
"""Messages that may wait while the node is busy: those of 100 s. None may be lost, for they tell changes."""


class Prior(Protocol):
    """As `inspection.flight.PriorMap`."""

    def tiles(self, resolution_m: float, side: int) -> np.ndarray:
        """Return (n, 3) the tiles of which it knows something."""

    def filled(self, resolution_m: float, side: int, tiles: np.ndarray, voxels: np.ndarray) -> np.ndarray:
        """Return the voxels of tiles (n, side**3) with what it knows in place of what is unknown."""


class MapFeed:
    """Takes ~updates. Call it under the planner's lock.

    Args:
        planner: gets the map. frame: that of the poses. keeps: a prior may come; then the map is kept, for
            slam_octomap tells a voxel only when it changes.

    Attributes:
        prior: what is known before the flight; it fills what the map does not know. None: nothing is.
    """

    def __init__(self, planner: PathPlanner, frame: str, keeps: bool = False) -> None:
        self._planner, self._frame, self._seq = planner, frame, 0
        self._connection: Any = None
        self._size: tuple[float, int] | None = None
        self._kept: dict[tuple[int, ...], np.ndarray] | None = {} if keeps else None
        self.prior: Prior | None = None

    def use(self, prior: Prior | None) -> None:
        """Let a prior fill what the map does not know, also of the map that is there already."""
        assert self._kept is not None
        self.prior = prior
        self._planner.clear_map()
        if self._size is not None:
            self._begin(*self._size)
            if self._kept:
                self._update(*self._size, np.array(list(self._kept)), np.array(list(self._kept.values())))

    def take(self, message: Any) -> None:
        """Take a gridslam/VoxelTiles. If slam_octomap has started anew, the map begins anew.

        It has if its messages are numbered from 1 again. Some may have gone to others before this node was
        connected; then the connection is another one, whose first message is the whole map.

        Raises:
            FlightBasicsError: the message makes no sense; this part of the map is left out.
        """
        frame = message.header.frame_id.lstrip("/")
        if frame != self._frame:
            raise PoseError(
                f'The map is in frame "{frame}", but poses are in "{self._frame}"; set pose_source.'
            )
        tiles, voxels = planner_messages.tiles_of(message)
        size = message.resolution, message.side
        before, self._connection = self._connection, getattr(message, "_connection_header", None)
        is_anew = message.header.seq < self._seq or (before is not None and before is not self._connection)
        if is_anew:
            self._planner.clear_map()
        if is_anew or size != self._size:
            self._kept = None if self._kept is None else {}
        self._seq, self._size = message.header.seq, size
        if self._kept is not None:
            self._kept.update(zip(map(tuple, tiles.tolist()), voxels))
        if not self._planner.has_map:
            self._begin(*size)
        self._update(*size, tiles, voxels)

    def _begin(self, resolution_m: float, side: int) -> None:
        """Begin the planner's map with what is known before."""
        if self.prior is not None:
            known = self.prior.tiles(resolution_m, side)
            self._update(resolution_m, side, known, np.zeros((len(known), side**3), np.uint8))

    def _update(self, resolution_m: float, side: int, tiles: np.ndarray, voxels: np.ndarray) -> None:
        if self.prior is not None:
            voxels = self.prior.filled(resolution_m, side, tiles, voxels)
        self._planner.update_map(resolution_m, side, tiles, voxels)
