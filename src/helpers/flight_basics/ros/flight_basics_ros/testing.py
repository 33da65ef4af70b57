"""The messages of the node tests, and what takes them."""

from __future__ import annotations

import math

import rospy
from geometry_msgs.msg import TransformStamped, TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage


class Newest:
    """The newest message of a topic."""

    def __init__(self, topic, kind):
        self.last = None
        self._subscriber = rospy.Subscriber(topic, kind, self._take)

    def _take(self, message):
        self.last = message


def scan_of(stamp, ranges, turn=1440, intensities=(), frame="hokuyo", limits=(0.06, 10.0)):
    """A scan from -135 degrees on, `turn` of whose beams would make a full turn."""
    scan = LaserScan()
    scan.header.stamp = stamp
    scan.header.frame_id = frame
    scan.angle_increment = 2.0 * math.pi / turn
    scan.angle_min = -0.75 * math.pi
    scan.angle_max = scan.angle_min + (len(ranges) - 1) * scan.angle_increment
    scan.range_min, scan.range_max = limits
    scan.scan_time = 0.025
    scan.ranges = list(ranges)
    scan.intensities = list(intensities)
    return scan


def bad_scans(stamps):
    """(scan, words of the warning) for each way in which a scan can make no sense."""
    good = [2.0] * 9

    def broken(**changes):
        scan = scan_of(stamps.next(), good)
        for name, value in changes.items():
            setattr(scan, name, value)
        return scan

    return [
        (scan_of(stamps.next(), []), "no beams"),
        (broken(ranges=good[:-3]), "has 6 ranges, but its angles ask for 9"),
        (broken(intensities=[1.0, 2.0]), "2 intensities for 9 ranges"),
        (broken(angle_increment=0.0), "angle_increment is 0.0"),
        (broken(angle_increment=math.nan), "angle_increment is nan"),
        (broken(angle_min=math.nan), "angle_min is nan"),
        (broken(angle_max=math.nan), "its angles ask for nan"),
        (broken(range_max=-1.0), "range_max -1.0 m"),
        (broken(range_max=math.nan), "range_max nan m"),
    ]


def odometry_of(stamp, position=(0.0, 0.0, 2.0), yaw=0.0, frame="odom", child="base_frame"):
    odometry = Odometry()
    odometry.header.stamp = stamp
    odometry.header.frame_id = frame
    odometry.child_frame_id = child
    p, q = odometry.pose.pose.position, odometry.pose.pose.orientation
    p.x, p.y, p.z = position
    q.z, q.w = math.sin(yaw / 2.0), math.cos(yaw / 2.0)
    return odometry


def velocity_of(stamp, linear, frame="base_frame"):
    command = TwistStamped()
    command.header.stamp = stamp
    command.header.frame_id = frame
    v = command.twist.linear
    v.x, v.y, v.z = linear
    return command


def correction(stamp, x, y, yaw):
    """map -> odom as SLAM broadcasts it."""
    transform = TransformStamped()
    transform.header.stamp = stamp
    transform.header.frame_id, transform.child_frame_id = "map", "odom"
    transform.transform.translation.x, transform.transform.translation.y = x, y
    transform.transform.rotation.z = math.sin(yaw / 2.0)
    transform.transform.rotation.w = math.cos(yaw / 2.0)
    return TFMessage([transform])
