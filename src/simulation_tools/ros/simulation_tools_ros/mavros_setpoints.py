"""MAVROS's setpoint topics: each message goes out as MAVLink inside its callback."""

from __future__ import annotations

import math
import time

import rospy
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from mavros_msgs.msg import AttitudeTarget, PositionTarget

from simulation_tools.errors import SimulationToolsError
from simulation_tools.mavros.client import FcuClient
from simulation_tools.mavros.conversions import (
    attitude_target,
    pose_target,
    position_target,
    velocity_target,
)

MAV_FRAMES = {"LOCAL_NED": 1, "BODY_NED": 8}


class MavrosSetpoints:
    """The subscribers. A setpoint's time_boot_ms is its stamp, or now for a stamp of zero."""

    def __init__(self, client: FcuClient) -> None:
        """Read the frame of velocities from the node's parameters and subscribe."""
        frame = rospy.get_param("~setpoint_velocity/mav_frame", "LOCAL_NED")
        if frame not in MAV_FRAMES:
            raise SimulationToolsError(
                f"~setpoint_velocity/mav_frame must be LOCAL_NED or BODY_NED, not {frame!r}."
            )
        self._client = client
        self._target = client.target
        self._velocity_frame = MAV_FRAMES[frame]
        self._refused: dict[str, float] = {}  # when a topic's setpoint was refused last, wall time
        for name, message_class, callback in (
            ("setpoint_position/local", PoseStamped, self._on_pose),
            ("setpoint_velocity/cmd_vel", TwistStamped, self._on_velocity),
            ("setpoint_velocity/cmd_vel_unstamped", Twist, self._on_unstamped_velocity),
            ("setpoint_raw/local", PositionTarget, self._on_raw),
            ("setpoint_raw/attitude", AttitudeTarget, self._on_attitude),
        ):
            rospy.Subscriber("~" + name, message_class, callback, queue_size=1, tcp_nodelay=True)

    def _forward(self, topic: str, header, build) -> None:
        """Build a setpoint's MAVLink message and send it; refuse what makes no setpoint."""
        stamp = header.stamp if header is not None and not header.stamp.is_zero() else rospy.get_rostime()
        try:
            message = build(stamp.to_nsec() // 1_000_000)
        except ValueError as error:
            if time.monotonic() - self._refused.get(topic, -math.inf) > 1.0:
                self._refused[topic] = time.monotonic()
                rospy.logwarn(f"A setpoint on {topic} is refused: {error}.")
            return
        if not self._client.send(message):
            rospy.logwarn_throttle(1.0, f"A setpoint on {topic} could not be sent to the flight controller.")

    def _on_pose(self, message: PoseStamped) -> None:
        p, q = message.pose.position, message.pose.orientation
        self._forward(
            "setpoint_position/local",
            message.header,
            lambda ms: pose_target(self._target, ms, (p.x, p.y, p.z), (q.x, q.y, q.z, q.w)),
        )

    def _on_velocity(self, message: TwistStamped) -> None:
        self._forward_velocity("setpoint_velocity/cmd_vel", message.header, message.twist)

    def _on_unstamped_velocity(self, message: Twist) -> None:
        self._forward_velocity("setpoint_velocity/cmd_vel_unstamped", None, message)

    def _forward_velocity(self, topic: str, header, twist: Twist) -> None:
        linear = (twist.linear.x, twist.linear.y, twist.linear.z)
        self._forward(
            topic,
            header,
            lambda ms: velocity_target(self._target, ms, self._velocity_frame, linear, twist.angular.z),
        )

    def _on_raw(self, message: PositionTarget) -> None:
        p, v, a = message.position, message.velocity, message.acceleration_or_force
        self._forward(
            "setpoint_raw/local",
            message.header,
            lambda ms: position_target(
                self._target,
                ms,
                message.coordinate_frame,
                message.type_mask,
                (p.x, p.y, p.z),
                (v.x, v.y, v.z),
                (a.x, a.y, a.z),
                message.yaw,
                message.yaw_rate,
            ),
        )

    def _on_attitude(self, message: AttitudeTarget) -> None:
        q, w = message.orientation, message.body_rate
        self._forward(
            "setpoint_raw/attitude",
            message.header,
            lambda ms: attitude_target(
                self._target, ms, message.type_mask, (q.x, q.y, q.z, q.w), (w.x, w.y, w.z), message.thrust
            ),
        )
