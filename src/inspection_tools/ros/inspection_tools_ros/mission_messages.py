"""Converts between a mission's messages and its waypoints."""

from __future__ import annotations

from typing import Sequence

from flight_basics_ros.pose_messages import pose_of
from geometry_msgs.msg import Point, Pose, PoseArray, Quaternion

from flight_basics.geometry import Vector3, yaw_of
from inspection_tools import Waypoint
from inspection_tools.mission.waypoints import headings_shown
from node_tools.conversions import set_yaw, xyzw


def waypoint_of(pose: Pose, tolerance_m: float, hold_s: float) -> Waypoint:
    """Return the waypoint of a goal's pose; an orientation of zeros leaves the heading open.

    Raises:
        PoseError: as `pose_of`.
    """
    turned = any(xyzw(pose.orientation))
    if not turned:
        pose = Pose(pose.position, Quaternion(0.0, 0.0, 0.0, 1.0))
    position_m, orientation = pose_of(pose)
    return Waypoint(position_m, yaw_of(orientation) if turned else None, tolerance_m, hold_s)


def setpoint(position_m: Vector3, yaw_rad: float | None) -> Pose:
    """Return the pose to fly to. Without a heading its yaw is 0."""
    pose = Pose(position=Point(*position_m))
    set_yaw(pose.orientation, yaw_rad or 0.0)
    return pose


def plan(waypoints: Sequence[Waypoint], frame: str) -> PoseArray:
    """Return the mission for RViz. Each pose points along its heading, or to the next waypoint."""
    headings = headings_shown(waypoints)
    poses = [setpoint(waypoint.position_m, yaw) for waypoint, yaw in zip(waypoints, headings)]
    message = PoseArray(poses=poses)
    message.header.frame_id = frame
    return message
