"""From the filter's results to ROS messages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Sequence

import numpy as np
import rospy
from geometry_msgs.msg import Point, Pose, PoseArray, PoseStamped
from nav_msgs.msg import OccupancyGrid as GridMessage
from nav_msgs.msg import Path
from rospy.numpy_msg import numpy_msg
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker

from gridslam import MapError, OccupancyGrid
from gridslam.trajectory import Trajectory
from node_tools.conversions import set_yaw

if TYPE_CHECKING:
    from gridslam.loop_closure import Closure  # slow to import

CLOSURE_WIDTH_M, CLOSURE_COLOUR = 0.2, (0.08, 0.6, 0.24, 1.0)
NumpyGridMessage = numpy_msg(GridMessage)
"""GridMessage whose data is an array. It is sent at once instead of cell by cell."""


def header_of(stamp_s: float, frame: str) -> Header:
    """Return a header."""
    return Header(stamp=rospy.Time.from_sec(stamp_s), frame_id=frame)


def grid_message(grid: OccupancyGrid, header: Header) -> GridMessage:
    """Return the map as a message."""
    message = NumpyGridMessage(header=header, data=grid.cells.ravel())
    message.info.map_load_time = header.stamp
    message.info.resolution = grid.resolution_m
    message.info.height, message.info.width = grid.cells.shape
    message.info.origin = pose_message(*grid.origin_xy_m, 0.0)
    return message


def grid_of(message: GridMessage) -> OccupancyGrid:
    """Return the map of a message.

    Raises:
        MapError: it makes no sense, or is turned.
    """
    info = message.info
    if abs(info.origin.orientation.z) > 1e-9:
        raise MapError("The map is turned against its frame; only maps with yaw 0 are understood.")
    cells = np.asarray(message.data, dtype=np.int8)
    if cells.size != info.width * info.height:
        raise MapError(f"The map says {info.width} x {info.height} cells, but holds {cells.size}.")
    origin = info.origin.position
    return OccupancyGrid(cells.reshape(info.height, info.width), info.resolution, (origin.x, origin.y))


def particles_message(poses: np.ndarray, header: Header) -> PoseArray:
    """Return poses (n, 3) of the particles as a message."""
    return PoseArray(header=header, poses=[pose_message(*pose) for pose in poses.tolist()])


def path_message(trajectory: Trajectory, header: Header) -> Path:
    """Return a trajectory as a message. z is the height as far as it is known, and else 0."""
    path = Path(header=header)
    rows = zip(trajectory.stamps_s.tolist(), trajectory.poses_in_map.tolist(), _heights_of(trajectory))
    path.poses = [
        PoseStamped(header=header_of(stamp_s, header.frame_id), pose=pose_message(x, y, yaw, z))
        for stamp_s, (x, y, yaw), z in rows
    ]
    return path


def closures_message(closures: Sequence[Closure], trajectory: Trajectory, header: Header) -> Marker:
    """Return the closed loops as lines. Each line joins two points of the path at the same place."""
    marker = Marker(header=header, ns="closures", type=Marker.LINE_LIST)
    if not closures:
        marker.action = Marker.DELETE
        return marker
    marker.pose.orientation.w = 1.0
    marker.scale.x = CLOSURE_WIDTH_M
    marker.color = ColorRGBA(*CLOSURE_COLOUR)
    stamps_s = [stamp_s for closure in closures for stamp_s in (closure.stamp_from_s, closure.stamp_to_s)]
    nodes = np.searchsorted(trajectory.stamps_s, np.array(stamps_s) - 1e-6)
    nodes = np.minimum(nodes, len(trajectory.stamps_s) - 1)
    heights_m = np.array(_heights_of(trajectory))[nodes].tolist()
    places_xy = trajectory.poses_in_map[nodes, :2].tolist()
    marker.points = [Point(x, y, z) for (x, y), z in zip(places_xy, heights_m)]
    return marker


def _heights_of(trajectory: Trajectory) -> list[float]:
    """Return the heights (k) of a path, m; 0 where they are not known."""
    if trajectory.heights_m is None:
        return [0.0] * len(trajectory.stamps_s)
    return np.nan_to_num(trajectory.heights_m).tolist()


def pose_message(x: float, y: float, yaw: float, z: float = 0.0) -> Pose:
    """Return a level pose as a message."""
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z = x, y, z
    set_yaw(pose.orientation, yaw)
    return pose
