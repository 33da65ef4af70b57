"""MAVROS's plugin `setpoint_accel`."""

from __future__ import annotations

import rospy
from geometry_msgs.msg import Vector3Stamped

from simulation_tools.mavros.conversions import acceleration_target
from simulation_tools_ros.mavros.uas import Uas


class SetpointAccelPlugin:
    """Takes setpoint_accel/accel, ENU. Parameter: ~setpoint_accel/send_force."""

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._is_force = bool(rospy.get_param("~setpoint_accel/send_force", False))
        uas.subscribe("setpoint_accel/accel", Vector3Stamped, self._on_acceleration)

    def _on_acceleration(self, message: Vector3Stamped) -> None:
        a = message.vector
        self._uas.send_setpoint(
            "setpoint_accel/accel",
            message.header,
            lambda ms: acceleration_target(self._uas.client.target, ms, (a.x, a.y, a.z), self._is_force),
        )
