"""MAVROS's plugin `odom`."""

from __future__ import annotations

import rospy
from geometry_msgs.msg import Point, Quaternion, Vector3
from nav_msgs.msg import Odometry
from pymavlink.dialects.v20 import common
from std_msgs.msg import Header

from node_tools.conversions import xyz, xyzw
from simulation_tools.mavros.external_estimates import Motion, motion_of, odometry_estimate
from simulation_tools_ros.mavros.uas import Uas, stamp_from_us


class OdometryPlugin:
    """Takes odometry/out for the flight controller, and publishes its own estimate as odometry/in.

    Parameters: ~odometry/fcu/{odom_parent_id_des,odom_child_id_des,map_id_des}; by default ~odom_frame_id,
    ~base_link_frame_id, ~map_frame_id (odom, base_link, map). odometry/out must be in the first two of them:
    MAVROS asks TF about other frames and turns, but does not shift, what is in them.
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._odom_frame, self._base_frame, self._map_frame = (
            rospy.get_param(f"~odometry/fcu/{wanted}", rospy.get_param(f"~{general}", name))
            for wanted, general, name in (
                ("odom_parent_id_des", "odom_frame_id", "odom"),
                ("odom_child_id_des", "base_link_frame_id", "base_link"),
                ("map_id_des", "map_frame_id", "map"),
            )
        )
        self._from_fcu = uas.advertise("odometry/in", Odometry)
        uas.client.on("ODOMETRY", self._on_odometry)
        uas.subscribe("odometry/out", Odometry, self._on_estimate)

    def _on_estimate(self, message: Odometry) -> None:
        self._uas.send_built("An estimate on odometry/out", lambda: self._mavlink_message(message))

    def _mavlink_message(self, message: Odometry) -> common.MAVLink_message:
        frames = (message.header.frame_id, message.child_frame_id)
        if frames != (self._odom_frame, self._base_frame):
            raise ValueError(
                f"it is of {frames[1]!r} in {frames[0]!r}, not of {self._base_frame!r} in "
                f"{self._odom_frame!r} (the parameters odometry/fcu/odom_child_id_des and odom_parent_id_des)"
            )
        pose, twist = message.pose, message.twist
        motion = Motion(
            xyz(pose.pose.position),
            xyzw(pose.pose.orientation),
            pose.covariance,
            xyz(twist.twist.linear),
            xyz(twist.twist.angular),
            twist.covariance,
        )
        return odometry_estimate(message.header.stamp.to_nsec() // 1000, motion)

    def _on_odometry(self, message: common.MAVLink_message) -> None:
        self._from_fcu.publish(lambda: self._odometry_message(message))

    def _odometry_message(self, message: common.MAVLink_message) -> Odometry:
        motion = motion_of(message)
        odometry = Odometry(
            header=Header(stamp=stamp_from_us(message.time_usec), frame_id=self._map_frame),
            child_frame_id=self._base_frame,
        )
        pose, twist = odometry.pose, odometry.twist
        pose.pose.position = Point(*motion.position)
        pose.pose.orientation = Quaternion(*motion.orientation_xyzw)
        pose.covariance = motion.pose_covariance
        twist.twist.linear, twist.twist.angular = Vector3(*motion.linear), Vector3(*motion.angular)
        twist.covariance = motion.twist_covariance
        return odometry
