"""MAVROS's plugin `local_position`."""

from __future__ import annotations

from typing import Sequence

import rospy
from genpy import Time
from geometry_msgs.msg import (
    AccelWithCovarianceStamped,
    Point,
    PoseStamped,
    PoseWithCovarianceStamped,
    Quaternion,
    TwistStamped,
    TwistWithCovarianceStamped,
    Vector3,
)
from nav_msgs.msg import Odometry
from pymavlink.dialects.v20 import common
from std_msgs.msg import Header

from simulation_tools.geometry import rotate, rotate_inverse
from simulation_tools.ned_frames import enu_to_ned
from simulation_tools_ros.mavros.uas import Heard, Uas, stamp_from_ms, stamp_from_us


class LocalPositionPlugin:
    """Publishes local_position/{pose,velocity_local,velocity_body,odom}.

    As in MAVROS, {pose_cov,velocity_body_cov,accel} come from LOCAL_POSITION_NED_COV, which PX4 does not
    have. They are silent until a client asks the stand-in for it (set_message_interval 64). Then odom comes
    from it, too.
    Parameters: ~local_position/frame_id, ~local_position/tf/child_frame_id.
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._frame_id = rospy.get_param("~local_position/frame_id", "map")
        self._child_frame_id = rospy.get_param("~local_position/tf/child_frame_id", "base_link")
        self._heard_covariance: Heard | None = None
        self._pose = uas.advertise("local_position/pose", PoseStamped)
        self._velocity_local = uas.advertise("local_position/velocity_local", TwistStamped)
        self._velocity_body = uas.advertise("local_position/velocity_body", TwistStamped)
        self._odometry = uas.advertise("local_position/odom", Odometry)
        self._pose_cov = uas.advertise("local_position/pose_cov", PoseWithCovarianceStamped)
        self._velocity_cov = uas.advertise("local_position/velocity_body_cov", TwistWithCovarianceStamped)
        self._acceleration = uas.advertise("local_position/accel", AccelWithCovarianceStamped)
        uas.client.on("LOCAL_POSITION_NED", self._on_position)
        uas.client.on("LOCAL_POSITION_NED_COV", self._on_position_with_covariance)

    def _on_position(self, position: common.MAVLink_message) -> None:
        heard = self._uas.heard
        if heard.attitude is None:
            return
        stamp = stamp_from_ms(position.time_boot_ms)
        self._pose.publish(lambda: self._pose_message(position, stamp))
        self._velocity_body.publish(lambda: self._velocity_body_message(position, stamp))
        self._velocity_local.publish(lambda: self._velocity_local_message(position, stamp))
        if self._heard_covariance is not heard:
            self._odometry.publish(lambda: self._odometry_message(position, stamp))

    def _on_position_with_covariance(self, position: common.MAVLink_message) -> None:
        heard = self._uas.heard
        if heard.attitude is None:
            return
        self._heard_covariance = heard
        topics = (self._odometry, self._pose_cov, self._velocity_cov, self._acceleration)
        if not any(topic.wanted for topic in topics):
            return
        odometry = self._odometry_message(position, stamp_from_us(position.time_usec))
        # The upper triangle of 9 x 9: position, velocity, acceleration
        variances = [position.covariance[i] for i in (0, 9, 17, 24, 30, 35, 39, 42, 44)]
        odometry.pose.covariance[0:15:7] = variances[:3]
        odometry.twist.covariance[0:15:7] = variances[3:6]
        body = Header(stamp=odometry.header.stamp, frame_id=self._child_frame_id)
        self._odometry.publish(lambda: odometry)
        self._pose_cov.publish(lambda: PoseWithCovarianceStamped(odometry.header, odometry.pose))
        self._velocity_cov.publish(lambda: TwistWithCovarianceStamped(body, odometry.twist))
        self._acceleration.publish(lambda: _acceleration_message(odometry.header, position, variances[6:]))

    def _pose_message(self, position: common.MAVLink_message, stamp: Time) -> PoseStamped:
        pose = PoseStamped(header=Header(stamp=stamp, frame_id=self._frame_id))
        pose.pose.position = Point(*enu_to_ned((position.x, position.y, position.z)))
        pose.pose.orientation = Quaternion(*self._uas.heard.attitude_or_level)
        return pose

    def _velocity_body_message(self, position: common.MAVLink_message, stamp: Time) -> TwistStamped:
        """FLU."""
        twist = TwistStamped(header=Header(stamp=stamp, frame_id=self._child_frame_id))
        twist.twist.linear = Vector3(
            *rotate_inverse(self._uas.heard.attitude_or_level, _velocity_enu(position))
        )
        twist.twist.angular = Vector3(*self._uas.heard.rates)
        return twist

    def _velocity_local_message(self, position: common.MAVLink_message, stamp: Time) -> TwistStamped:
        """ENU, although MAVROS's header says the body's frame."""
        heard = self._uas.heard
        twist = TwistStamped(header=Header(stamp=stamp, frame_id=self._child_frame_id))
        twist.twist.linear = Vector3(*_velocity_enu(position))
        twist.twist.angular = Vector3(*rotate(heard.attitude_or_level, heard.rates))
        return twist

    def _odometry_message(self, position: common.MAVLink_message, stamp: Time) -> Odometry:
        pose = self._pose_message(position, stamp)
        odometry = Odometry(header=pose.header, child_frame_id=self._child_frame_id)
        odometry.pose.pose = pose.pose
        odometry.twist.twist = self._velocity_body_message(position, stamp).twist
        return odometry


def _acceleration_message(
    header: Header, position: common.MAVLink_message, variances: Sequence[float]
) -> AccelWithCovarianceStamped:
    """ENU."""
    message = AccelWithCovarianceStamped(header=header)
    message.accel.accel.linear = Vector3(*enu_to_ned((position.ax, position.ay, position.az)))
    message.accel.covariance[0:15:7] = variances
    return message


def _velocity_enu(position: common.MAVLink_message) -> tuple[float, float, float]:
    return enu_to_ned((position.vx, position.vy, position.vz))
