"""Passes the map of `slam_octomap` on to a planner."""

from __future__ import annotations

from typing import Any

from inspection_tools.errors import PoseError
from inspection_tools.planning import PathPlanner
from inspection_tools_ros import planner_messages


class MapFeed:
    """Takes ~updates. Call it under the planner's lock.

    Args:
        planner: gets the map. frame: that of the poses.
    """

    def __init__(self, planner: PathPlanner, frame: str) -> None:
        self._planner, self._frame, self._seq = planner, frame, 0

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
        self._planner.update_map(message.resolution, message.side, tiles, voxels)
