"""Poses of messages in plain numbers. Every fault of a message gives an error of one sentence."""

from __future__ import annotations

import math

from geometry_msgs.msg import Pose
from nav_msgs.msg import Odometry

from flight_basics.bounds import FARTHEST_M
from flight_basics.errors import PoseError
from flight_basics.geometry import Quaternion, Vector3, normalised
from node_tools.conversions import xyz, xyzw


def pose_of(pose: Pose) -> tuple[Vector3, Quaternion]:
    """Return position (x, y, z) and unit quaternion (x, y, z, w) of a geometry_msgs/Pose.

    Raises:
        PoseError: not finite, farther away than anything flies, or without an orientation.
    """
    position_m = xyz(pose.position)
    if not all(math.isfinite(coordinate) for coordinate in position_m):
        raise PoseError("The pose has a position that is not finite.")
    if max(map(abs, position_m)) > FARTHEST_M:
        raise PoseError(f"The pose has a position beyond {FARTHEST_M:g} m; check its source.")
    return position_m, normalised(xyzw(pose.orientation))


def require_frames(odometry: Odometry, frame: str, child_frame: str) -> None:
    """Check the frames of a nav_msgs/Odometry. An empty child frame is taken for the right one.

    Raises:
        PoseError: another frame.
    """
    given, child = odometry.header.frame_id.lstrip("/"), odometry.child_frame_id.lstrip("/")
    if given != frame or child not in ("", child_frame):
        raise PoseError(
            f'The pose is of frame "{child}" in "{given}", but "{child_frame}" in "{frame}" is expected.'
        )
