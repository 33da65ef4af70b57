"""From the lidar odometry's estimates to ROS messages."""

from __future__ import annotations

import math

from genpy import Time
from geometry_msgs.msg import Point, Quaternion, TransformStamped, Vector3
from nav_msgs.msg import Odometry
from std_msgs.msg import Header

from gridslam.odometry import OdometryEstimate


def odometry_message(
    stamp: Time, estimate: OdometryEstimate, odom_frame: str, base_frame: str, matched: bool = False
) -> Odometry:
    """Return nav_msgs/Odometry: the pose in ``odom_frame``, the twist along the axes of ``base_frame``.

    matched: the pose's covariance is that against the local map, without the drift.
    """
    message = Odometry(header=Header(stamp=stamp, frame_id=odom_frame), child_frame_id=base_frame)
    pose, twist = message.pose, message.twist
    pose.pose.position = Point(*estimate.position_xyz)
    pose.pose.orientation = _quaternion(*estimate.roll_pitch_yaw)
    covariance = estimate.matched_covariance if matched else estimate.pose_covariance
    pose.covariance = covariance.ravel().tolist()
    twist.twist.linear, twist.twist.angular = Vector3(*estimate.velocity_xyz), Vector3(*estimate.rates_rad_s)
    twist.covariance = estimate.velocity_covariance.ravel().tolist()
    return message


def transform_of(odometry: Odometry) -> TransformStamped:
    """Return the pose of an odometry message as a transform."""
    message = TransformStamped(header=odometry.header, child_frame_id=odometry.child_frame_id)
    position = odometry.pose.pose.position
    message.transform.translation = Vector3(position.x, position.y, position.z)
    message.transform.rotation = odometry.pose.pose.orientation
    return message


def _quaternion(roll_rad: float, pitch_rad: float, yaw_rad: float) -> Quaternion:
    cr, sr = math.cos(roll_rad / 2), math.sin(roll_rad / 2)
    cp, sp = math.cos(pitch_rad / 2), math.sin(pitch_rad / 2)
    cy, sy = math.cos(yaw_rad / 2), math.sin(yaw_rad / 2)
    return Quaternion(
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )
