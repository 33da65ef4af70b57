"""Reads initialpose, as RViz's 2D Pose Estimate and AMCL have it."""

from __future__ import annotations

import math

import numpy as np
from geometry_msgs.msg import PoseWithCovarianceStamped

from gridslam import PoseError
from node_tools.conversions import xyz, xyzw, yaw_of_xyzw

PLANE = (0, 1, 5)
"""Rows of x, y and yaw in the covariance of a message."""
UNIT_TOLERANCE = 1e-2


def initial_pose_of(
    message: PoseWithCovarianceStamped, map_frame: str
) -> tuple[tuple[float, float, float], np.ndarray]:
    """Return (pose x, y in m and yaw in rad, covariance (3, 3)) of a message.

    Raises:
        PoseError: it is in another frame than the map's, or its orientation is none.
    """
    frame = message.header.frame_id.lstrip("/")
    if frame != map_frame.lstrip("/"):
        raise PoseError(f'An initialpose must be in the frame "{map_frame}", not in "{frame}".')
    position, orientation = xyz(message.pose.pose.position), xyzw(message.pose.pose.orientation)
    if not all(math.isfinite(value) for value in (*position, *orientation)):
        raise PoseError("An initialpose must have finite numbers.")
    if abs(math.hypot(*orientation) - 1.0) > UNIT_TOLERANCE:
        raise PoseError(f"The orientation of an initialpose must be a unit quaternion, not {orientation}.")
    covariance = np.reshape(message.pose.covariance, (6, 6))[np.ix_(PLANE, PLANE)]
    return (position[0], position[1], yaw_of_xyzw(orientation)), covariance
