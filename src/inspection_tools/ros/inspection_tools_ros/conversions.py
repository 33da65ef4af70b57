"""Converts messages to the library's types. Every fault of a message gives an error of one sentence."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np
from flight_basics_ros.pose_messages import pose_of
from geometry_msgs.msg import Point, TwistStamped
from geometry_msgs.msg import Quaternion as QuaternionMessage
from geometry_msgs.msg import Vector3 as Vector3Message
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

from flight_basics.errors import ScanError, VelocityError
from flight_basics.geometry import Vector3
from input_checks_ros.lidar_readings import UNSEEN_INTENSITY
from inspection_tools.padding import PaddedScan
from inspection_tools.scan import ScanGeometry
from inspection_tools.vision_pose import Motion
from node_tools.conversions import time_of, xyz

GREATEST_SPEED_M_S = 1e6
MOST_STEPS_BEHIND = 1.99
"""Steps of a scan from its last beam to angle_max: fewer than two, less what rounding to 32 bits adds."""


def scan_geometry(scan: LaserScan) -> ScanGeometry:
    """Return the geometry of a sensor_msgs/LaserScan whose array lengths agree with its angles.

    The last beam may lie before angle_max, because the step is seldom a whole part of the angle: by up to one
    step in a scan of pointcloud_to_laserscan, by up to two in one of velodyne_laserscan.

    Raises:
        ScanError: no beams, impossible angles, or lengths that disagree.
    """
    beams = len(scan.ranges)
    geometry = ScanGeometry(beams, scan.angle_min, scan.angle_increment)
    steps = (scan.angle_max - scan.angle_min) / scan.angle_increment
    if not -0.5 < steps - (beams - 1) < MOST_STEPS_BEHIND:
        raise ScanError(
            f"The scan has {beams} ranges, but its angles ask for {steps + 1.0:.0f}; check the driver."
        )
    if len(scan.intensities) not in (0, beams):
        raise ScanError(
            f"The scan has {len(scan.intensities)} intensities for {beams} ranges; give none or as many."
        )
    return geometry


def intensities_of(padded: PaddedScan, source: Sequence[float] = ()) -> np.ndarray:
    """Return the (n,) float32 intensities of a padded scan's message, UNSEEN_INTENSITY where it is unseen.

    source: intensities of the scan it came from; without them a seen beam has 0.
    """
    intensities = np.where(padded.seen, np.float32(0.0), np.float32(UNSEEN_INTENSITY))
    if len(source):
        beams = min(len(source), padded.geometry.beams)  # beams beyond a turn repeat the first ones
        intensities[padded.first_beam : padded.first_beam + beams] = source[:beams]
    return intensities


def motion_of(odometry: Odometry) -> Motion:
    """Return a nav_msgs/Odometry in plain numbers.

    Raises:
        PoseError: as ``pose_of``.
    """
    position_m, orientation = pose_of(odometry.pose.pose)
    twist = odometry.twist
    return Motion(
        odometry.header.stamp.to_nsec(),
        position_m,
        orientation,
        xyz(twist.twist.linear),
        xyz(twist.twist.angular),
        odometry.pose.covariance,
        twist.covariance,
    )


def odometry_of(motion: Motion, frame: str, child_frame: str) -> Odometry:
    """Return a nav_msgs/Odometry of plain numbers."""
    odometry = Odometry(child_frame_id=child_frame)
    odometry.header.stamp, odometry.header.frame_id = time_of(motion.stamp_ns), frame
    pose, twist = odometry.pose, odometry.twist
    pose.pose.position = Point(*motion.position_m)
    pose.pose.orientation = QuaternionMessage(*motion.orientation_xyzw)
    pose.covariance = motion.pose_covariance
    twist.twist.linear = Vector3Message(*motion.velocity_m_s)
    twist.twist.angular = Vector3Message(*motion.rates_rad_s)
    twist.covariance = motion.twist_covariance
    return odometry


def body_velocity_of(command: TwistStamped, base_frame: str) -> Vector3:
    """Return the linear velocity (x, y, z) of a geometry_msgs/TwistStamped in the body frame.

    Raises:
        VelocityError: as ``velocity_of``, or in another frame (none at all means the body frame).
    """
    frame = command.header.frame_id.lstrip("/")
    if frame not in ("", base_frame):
        raise VelocityError(f'The velocity is in frame "{frame}"; only "{base_frame}" is understood here.')
    return velocity_of(command)


def velocity_of(command: TwistStamped) -> Vector3:
    """Return the linear velocity (x, y, z) of a geometry_msgs/TwistStamped, in its own frame.

    Raises:
        VelocityError: not finite, or faster than anything flies.
    """
    velocity = xyz(command.twist.linear)
    if not all(math.isfinite(component) for component in velocity):
        raise VelocityError("The velocity has a component that is not finite.")
    if max(map(abs, velocity)) > GREATEST_SPEED_M_S:
        raise VelocityError(
            f"The velocity has a component beyond {GREATEST_SPEED_M_S:.0e} m/s; check its source."
        )
    return velocity
