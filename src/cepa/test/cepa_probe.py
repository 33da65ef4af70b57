"""What the node tests share: messages, and waiting for what comes of them, in wall time."""

from __future__ import annotations

import math
import time

import numpy as np
import rosgraph
import rosnode
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped, TwistStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import LaserScan

TIMEOUT_S = 30.0  # only those who wait in vain wait so long
QUIET_S = 0.3
BEAMS = 1440


def wait_until(condition, what: str, timeout_s: float = TIMEOUT_S) -> None:
    deadline = time.monotonic() + timeout_s
    while not condition():
        if time.monotonic() > deadline:
            raise AssertionError(f"waited {timeout_s:.0f} s in vain for {what}")
        time.sleep(0.003)


class Input:
    """A publisher that is known to be connected."""

    def __init__(self, topic, message_type):
        self._publisher = rospy.Publisher(topic, message_type, queue_size=10, tcp_nodelay=True)
        wait_until(lambda: self._publisher.get_num_connections() > 0, f"a subscriber of {topic}")

    def send(self, message):
        self._publisher.publish(message)


class Output:
    """Collects what a node publishes; known to be connected."""

    def __init__(self, topic, message_type):
        self.messages = []
        self._topic = topic
        self._subscriber = rospy.Subscriber(topic, message_type, self.messages.append, tcp_nodelay=True)
        wait_until(lambda: self._subscriber.get_num_connections() > 0, f"a publisher of {topic}")

    def next(self):
        wait_until(lambda: self.messages, f"a message on {self._topic}")
        return self.messages.pop(0)

    def of(self, stamp):
        """Wait for the message of one stamp; what came before it is dropped."""
        while True:
            message = self.next()
            header = message.header if hasattr(message, "header") else message.markers[0].header
            if header.stamp == stamp:
                return message

    def assert_quiet(self):
        time.sleep(QUIET_S)
        assert not self.messages, f"{self._topic} should be quiet, but said {self.messages[0]}"


class Warned:
    """Collects the warnings of one node; known to hear it."""

    def __init__(self, node):
        self.sentences = []
        self._node = node
        self._subscriber = rospy.Subscriber("/rosout", Log, self._on_log)
        wait_until(self._hears_node, f"the log of {node}")

    def _hears_node(self):
        address = rosnode.get_api_uri(rosgraph.Master(rospy.get_name()), self._node, skip_cache=True)
        return address in [connection[1] for connection in self._subscriber.impl.get_stats_info()]

    def _on_log(self, log):
        if log.name == self._node and log.level >= Log.WARN:
            self.sentences.append(log.msg)

    def wait_for(self, text):
        wait_until(lambda: self.count(text), f'a warning with "{text}" among {self.sentences}')

    def count(self, text):
        return sum(text in sentence for sentence in self.sentences)


class Stamps:
    """Stamps that go forward by a lidar's period."""

    def __init__(self, start_s):
        self._now = rospy.Time.from_sec(start_s)

    def next(self, step_s=0.025):
        self._now += rospy.Duration.from_sec(step_s)
        return self._now


class Mounts:
    """Publishes static transforms, all of them again with each new one."""

    def __init__(self):
        self._broadcaster = tf2_ros.StaticTransformBroadcaster()

    def add(self, parent, child, yaw=0.0, pitch=0.0, roll=0.0):
        transform = TransformStamped()
        transform.header.frame_id, transform.child_frame_id = parent, child
        cy, sy, cp, sp = math.cos(yaw / 2), math.sin(yaw / 2), math.cos(pitch / 2), math.sin(pitch / 2)
        cr, sr = math.cos(roll / 2), math.sin(roll / 2)
        q = transform.transform.rotation
        q.x, q.y = sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy
        q.z, q.w = cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy
        self._broadcaster.sendTransform(transform)


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


def odometry_of(stamp, velocity=(0.0, 0.0, 0.0), height=2.0, pitch=0.0):
    message = Odometry()
    message.pose.pose.position.z = height
    q = message.pose.pose.orientation
    q.y, q.w = math.sin(pitch / 2), math.cos(pitch / 2)
    message.header.stamp, message.header.frame_id, message.child_frame_id = stamp, "odom", "base_frame"
    v = message.twist.twist.linear
    v.x, v.y, v.z = velocity
    return message
