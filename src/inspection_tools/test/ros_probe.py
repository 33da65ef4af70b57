"""What the node tests share: send a message, wait for what comes of it, in wall time."""

from __future__ import annotations

import math
import time

import rosgraph
import rosnode
import rospy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import LaserScan

TIMEOUT_S = 30.0  # only those who wait in vain wait so long
QUIET_S = 0.3  # how long to wait before believing that nothing comes


def wait_until(condition, what: str) -> None:
    deadline = time.monotonic() + TIMEOUT_S
    while not condition():
        if time.monotonic() > deadline:
            raise AssertionError(f"waited {TIMEOUT_S:.0f} s in vain for {what}")
        time.sleep(0.005)


def address_of(node):
    """XML-RPC address of a node; None while there is no such node."""
    return rosnode.get_api_uri(rosgraph.Master(rospy.get_name()), node, skip_cache=True)


class Input:
    """A publisher that is known to be connected."""

    def __init__(self, topic, message_type):
        self._publisher = rospy.Publisher(topic, message_type, queue_size=10, tcp_nodelay=True)
        wait_until(lambda: self._publisher.get_num_connections() > 0, f"a subscriber of {topic}")

    def send(self, message):
        self._publisher.publish(message)


class Output:
    """Collects what a node publishes; known to be connected unless told otherwise."""

    def __init__(self, topic, message_type, connected=True):
        self.messages = []
        self._topic = topic
        self._subscriber = rospy.Subscriber(topic, message_type, self.messages.append, tcp_nodelay=True)
        if connected:
            wait_until(lambda: self._subscriber.get_num_connections() > 0, f"a publisher of {topic}")

    def next(self):
        """Wait for a message and take it."""
        wait_until(lambda: self.messages, f"a message on {self._topic}")
        return self.messages.pop(0)

    def assert_quiet(self):
        time.sleep(QUIET_S)
        assert not self.messages, f"{self._topic} should be quiet, but said {self.messages[0]}"


class Warned:
    """Collects the warnings of one node."""

    def __init__(self, node):
        self.sentences = []
        self._node = node
        self._subscriber = rospy.Subscriber("/rosout", Log, self._on_log)
        wait_until(self._hears_node, f"the log of {node}")

    def _hears_node(self):
        """/rosout is a topic like others: a node is heard only when it is connected."""
        endpoints = [connection[1] for connection in self._subscriber.impl.get_stats_info()]
        return address_of(self._node) in endpoints

    def _on_log(self, log):
        if log.name == self._node and log.level >= Log.WARN:
            self.sentences.append(log.msg)

    def wait_for(self, text):
        """Wait for a sentence that holds `text`; return how many there are."""
        wait_until(lambda: self.count(text), f'a warning with "{text}" among {self.sentences}')

    def count(self, text):
        return sum(text in sentence for sentence in self.sentences)


class Stamps:
    """A clock that goes forward by a lidar's period, and back on request."""

    def __init__(self, start_s=100.0):
        self._now = rospy.Time.from_sec(start_s)

    def next(self, step_s=0.025):
        self._now += rospy.Duration.from_sec(step_s)
        return self._now


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
