"""Converts between the path planner's messages and its arrays."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import roslib.message
from geometry_msgs.msg import Point, Pose, PoseStamped
from nav_msgs.msg import Path
from std_msgs.msg import Header

from flight_basics.errors import MapError, PoseError
from flight_basics.geometry import Vector3
from inspection_tools.msg import MissionActionGoal
from node_tools.conversions import set_yaw, xyz

TILES = "gridslam/VoxelTiles"
"""By its name, as rostopic does: this package builds without gridslam."""


def tiles_class() -> Any:
    """Return the class of the map's messages.

    Raises:
        MapError: no package of this workspace has it.
    """
    found = roslib.message.get_message_class(TILES)
    if found is None:
        raise MapError(f"The message {TILES} is not built; build the package gridslam.")
    return found


def tiles_of(message: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return tiles (n, 3) and voxels (n, side**3) of a gridslam/VoxelTiles.

    Raises:
        MapError: the lengths do not agree, or it holds distances.
    """
    tiles = np.array(message.tiles, np.int64)
    voxels = np.frombuffer(message.voxels, np.uint8)
    if message.unit != 0.0:
        raise MapError("The tiles hold distances; subscribe to ~updates of slam_octomap.")
    if tiles.size % 3 or voxels.size != tiles.size // 3 * message.side**3:
        raise MapError(f"{tiles.size / 3:g} tiles of {message.side}^3 voxels came as {voxels.size}.")
    return tiles.reshape(-1, 3), voxels.reshape(tiles.size // 3, message.side**3)


def place_of(name: str, header: Header, position: Point, frame: str) -> Vector3:
    """Return a place (x, y, z) in the map's frame.

    Raises:
        PoseError: another frame, or not finite.
    """
    given = header.frame_id.lstrip("/")
    if given != frame:
        raise PoseError(f'The {name} is in frame "{given}", but the map is in "{frame}".')
    if not all(map(math.isfinite, xyz(position))):
        raise PoseError(f"The {name} has a position that is not finite.")
    return xyz(position)


def path_of(points_m: np.ndarray, header: Header) -> Path:
    """Return a path's points (n, 3) as a message; each pose looks along the leg that follows."""
    path = Path(header=header)
    yaw_rad = 0.0
    ways = [*np.diff(points_m, axis=0), np.zeros(3)] if len(points_m) else []
    for point_m, way in zip(points_m, ways):
        if math.hypot(way[0], way[1]) > 1e-3:
            yaw_rad = math.atan2(way[1], way[0])
        pose = PoseStamped(header=header, pose=Pose(position=Point(*point_m)))
        set_yaw(pose.pose.orientation, yaw_rad)
        path.poses.append(pose)
    return path


def mission_goal(
    points_m: np.ndarray, identity: str, tolerance_m: float, header: Header
) -> MissionActionGoal:
    """Return the goal of a mission along a path (n, 3) that begins at the UAV. The heading is open."""
    message = MissionActionGoal(header=header)
    message.goal_id.stamp, message.goal_id.id = header.stamp, identity
    message.goal.waypoints = [Pose(position=Point(*point_m)) for point_m in points_m[1:]]
    message.goal.tolerance = tolerance_m
    return message
