"""MAVROS's plugin `setpoint_velocity`."""

from __future__ import annotations

from geometry_msgs.msg import Twist, TwistStamped
from std_msgs.msg import Header

from simulation_tools.mavros.conversions import velocity_target
from simulation_tools_ros.mavros.plugins.setpoints.mav_frame import MavFrame
from simulation_tools_ros.mavros.uas import Uas


class SetpointVelocityPlugin:
    """Takes setpoint_velocity/{cmd_vel,cmd_vel_unstamped}, ENU, or FLU in a body frame."""

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._frame = MavFrame(uas, "setpoint_velocity")
        uas.subscribe("setpoint_velocity/cmd_vel", TwistStamped, self._on_velocity)
        uas.subscribe("setpoint_velocity/cmd_vel_unstamped", Twist, self._on_unstamped)

    def _on_velocity(self, message: TwistStamped) -> None:
        self._forward("setpoint_velocity/cmd_vel", message.header, message.twist)

    def _on_unstamped(self, message: Twist) -> None:
        self._forward("setpoint_velocity/cmd_vel_unstamped", None, message)

    def _forward(self, topic: str, header: Header, twist: Twist) -> None:
        target, frame = self._uas.client.target, self._frame.number
        linear = (twist.linear.x, twist.linear.y, twist.linear.z)
        self._uas.send_setpoint(
            topic, header, lambda ms: velocity_target(target, ms, frame, linear, twist.angular.z)
        )
