"""Conversions between geometry_msgs and plain numbers; quaternions are (x, y, z, w), angles in radians."""

from __future__ import annotations

import math
from typing import Any

import rospy


def xyz(vector: Any) -> tuple[float, float, float]:
    """Return a geometry_msgs Vector3 or Point as numbers."""
    return vector.x, vector.y, vector.z


def xyzw(quaternion: Any) -> tuple[float, float, float, float]:
    """Return a geometry_msgs/Quaternion as numbers."""
    return quaternion.x, quaternion.y, quaternion.z, quaternion.w


def yaw_of(quaternion: Any) -> float:
    """Return the heading of a geometry_msgs/Quaternion of unit length, in (-pi, pi]."""
    return yaw_of_xyzw(xyzw(quaternion))


def yaw_of_xyzw(rotation_xyzw: tuple[float, float, float, float]) -> float:
    """Return the heading of a unit quaternion, in (-pi, pi]."""
    x, y, z, w = rotation_xyzw
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def set_yaw(quaternion: Any, yaw_rad: float) -> None:
    """Make a geometry_msgs/Quaternion a turn about z."""
    quaternion.x = quaternion.y = 0.0
    quaternion.z, quaternion.w = math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad)


def time_of(stamp_ns: int) -> rospy.Time:
    """Return nanoseconds as a stamp."""
    return rospy.Time(*divmod(stamp_ns, 1_000_000_000))
