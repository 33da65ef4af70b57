"""MAVROS's plugin `setpoint_position`."""

from __future__ import annotations

from typing import Any

import rospy
from geographic_msgs.msg import GeoPoseStamped
from geometry_msgs.msg import PoseStamped

from simulation_tools.mavros.conversions import global_pose_target, pose_target
from simulation_tools.mavros.earth import GeodeticPoint
from simulation_tools.ned_frames import enu_to_ned
from simulation_tools_ros.mavros.plugins.setpoints.mav_frame import MavFrame
from simulation_tools_ros.mavros.uas import Uas


class SetpointPositionPlugin:
    """Takes setpoint_position/{local,global,global_to_local}.

    The altitude of global is above mean sea level. That of global_to_local is above the ellipsoid, like that
    of global_position/global. As in MAVROS, the stamps of global_to_local must rise.
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._frame = MavFrame(uas, "setpoint_position")
        self._last_ms = 0
        uas.subscribe("setpoint_position/local", PoseStamped, self._on_local)
        uas.subscribe("setpoint_position/global", GeoPoseStamped, self._on_global)
        uas.subscribe("setpoint_position/global_to_local", GeoPoseStamped, self._on_global_to_local)

    def _on_local(self, message: PoseStamped) -> None:
        p, q = message.pose.position, message.pose.orientation
        target, frame = self._uas.client.target, self._frame.number
        self._uas.send_setpoint(
            "setpoint_position/local",
            message.header,
            lambda ms: pose_target(target, ms, (p.x, p.y, p.z), (q.x, q.y, q.z, q.w), frame),
        )

    def _on_global(self, message: GeoPoseStamped) -> None:
        p, q = message.pose.position, message.pose.orientation
        place = (p.latitude, p.longitude, p.altitude)
        self._uas.send_setpoint(
            "setpoint_position/global",
            message.header,
            lambda ms: global_pose_target(self._uas.client.target, ms, place, (q.x, q.y, q.z, q.w)),
        )

    def _on_global_to_local(self, message: GeoPoseStamped) -> None:
        q = message.pose.orientation
        stamp_ms = message.header.stamp.to_nsec() // 1_000_000
        if stamp_ms <= self._last_ms:
            rospy.logwarn_throttle(
                10.0, "A setpoint on setpoint_position/global_to_local is not sent: its stamp must rise."
            )
            return
        self._last_ms = stamp_ms
        target, frame = self._uas.client.target, self._frame.number
        self._uas.send_setpoint(
            "setpoint_position/global_to_local",
            message.header,
            lambda ms: pose_target(
                target, ms, self._to_local(message.pose.position), (q.x, q.y, q.z, q.w), frame
            ),
        )

    def _to_local(self, goal: Any) -> tuple[float, float, float]:
        """Return a place on earth in the local frame, ENU.

        The UAV's position in both frames connects them. Raises ValueError if that position is not known.
        """
        here, local = self._uas.heard.global_position, self._uas.heard.local_position
        if here is None or local is None:
            raise ValueError("the UAV's own position is not known yet")
        if not (abs(goal.latitude) <= 90.0 and abs(goal.longitude) <= 180.0):
            raise ValueError(f"latitude {goal.latitude}, longitude {goal.longitude} is not a place on earth")
        height_m = 1e-3 * here.alt + self._uas.geoid_height_m
        way = GeodeticPoint(1e-7 * here.lat, 1e-7 * here.lon, height_m).enu_to(
            GeodeticPoint(goal.latitude, goal.longitude, goal.altitude)
        )
        position = enu_to_ned((local.x, local.y, local.z))
        return (position[0] + way[0], position[1] + way[1], position[2] + way[2])
