"""The messages of the node tests."""

from __future__ import annotations

import math

import numpy as np
from geometry_msgs.msg import TransformStamped, TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from node_tools.testing import Input

BEAMS = 1440


def of_stamp(output, *stamps):
    """Wait for the message of one of the stamps; what came before it is dropped."""
    while True:
        message = output.next()
        header = message.header if hasattr(message, "header") else message.markers[0].header
        if header.stamp in stamps:
            return message


class Mounts:
    """Publishes static transforms, all of them again with each new one."""

    def __init__(self, topic="/tf_static"):
        self._input, self._transforms = Input(topic, TFMessage, latch=True), []

    def add(self, parent, child, yaw=0.0, pitch=0.0, roll=0.0):
        transform = TransformStamped()
        transform.header.frame_id, transform.child_frame_id = parent, child
        cy, sy, cp, sp = math.cos(yaw / 2), math.sin(yaw / 2), math.cos(pitch / 2), math.sin(pitch / 2)
        cr, sr = math.cos(roll / 2), math.sin(roll / 2)
        q = transform.transform.rotation
        q.x, q.y = sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy
        q.z, q.w = cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy
        self._transforms.append(transform)
        self._input.deliver(TFMessage(self._transforms))


def scan_of(stamp, ranges=None, frame="base_frame", **changes):
    """A full turn from -180 degrees on, open where nothing else is said."""
    scan = LaserScan()
    scan.header.stamp, scan.header.frame_id = stamp, frame
    scan.ranges = np.full(BEAMS, np.inf) if ranges is None else ranges
    scan.angle_min = -math.pi
    scan.angle_increment = 2.0 * math.pi / BEAMS
    scan.angle_max = scan.angle_min + (len(scan.ranges) - 1) * scan.angle_increment
    scan.range_min, scan.range_max = 0.06, 10.0
    for name, value in changes.items():
        setattr(scan, name, value)
    return scan


def column(bearing_degrees, distance, width_degrees=10.0):
    """Ranges of a full turn with one obstacle."""
    ranges = np.full(BEAMS, np.inf)
    first = round((bearing_degrees - width_degrees / 2 + 180.0) * BEAMS / 360.0)
    ranges[np.arange(first, first + round(width_degrees * BEAMS / 360.0)) % BEAMS] = distance
    return ranges


def velocity_of(stamp, linear, frame="base_frame"):
    message = TwistStamped()
    message.header.stamp, message.header.frame_id = stamp, frame
    v = message.twist.linear
    v.x, v.y, v.z = linear
    return message


def odometry_of(stamp, velocity=(0.0, 0.0, 0.0), height=2.0, pitch=0.0, x=0.0):
    message = Odometry()
    message.pose.pose.position.x = x
    message.pose.pose.position.z = height
    q = message.pose.pose.orientation
    q.y, q.w = math.sin(pitch / 2), math.cos(pitch / 2)
    message.header.stamp, message.header.frame_id, message.child_frame_id = stamp, "odom", "base_frame"
    v = message.twist.twist.linear
    v.x, v.y, v.z = velocity
    return message
