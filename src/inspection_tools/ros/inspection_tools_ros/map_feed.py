"""Passes the map of `slam_octomap` on to a planner."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from inspection_tools.errors import PoseError
from inspection_tools.planning import PathPlanner
from inspection_tools_ros import planner_messages


class Prior(Protocol):
    """As `inspection_tools.inspection.PriorMap`."""

    def tiles(self, resolution_m: float, side: int) -> np.ndarray:
        """Return (n, 3) the tiles of which it knows something."""

    def filled(self, resolution_m: float, side: int, tiles: np.ndarray, voxels: np.ndarray) -> np.ndarray:
        """Return the voxels of tiles (n, side**3) with what it knows in place of what is unknown."""


class MapFeed:
    """Takes ~updates. Call it under the planner's lock.

    Args:
        planner: gets the map. frame: that of the poses.

    Attributes:
        prior: what is known before the flight; it fills what the map does not know. None: nothing is.
    """

    def __init__(self, planner: PathPlanner, frame: str) -> None:
        self._planner, self._frame, self._seq = planner, frame, 0
        self.prior: Prior | None = None

    def take(self, message: Any) -> None:
        """Take a gridslam/VoxelTiles. If slam_octomap has started anew, the map begins anew.

        Raises:
            InspectionToolsError: the message makes no sense; this part of the map is left out.
        """
        frame = message.header.frame_id.lstrip("/")
        if frame != self._frame:
            raise PoseError(
                f'The map is in frame "{frame}", but poses are in "{self._frame}"; set pose_source.'
            )
        tiles, voxels = planner_messages.tiles_of(message)
        if message.header.seq < self._seq:
            self._planner.clear_map()
        self._seq = message.header.seq
        size = message.resolution, message.side
        if self.prior is not None:
            if not self._planner.has_map:
                known = self.prior.tiles(*size)
                unknown = np.zeros((len(known), message.side**3), np.uint8)
                self._planner.update_map(*size, known, self.prior.filled(*size, known, unknown))
            voxels = self.prior.filled(*size, tiles, voxels)
        self._planner.update_map(message.resolution, message.side, tiles, voxels)
