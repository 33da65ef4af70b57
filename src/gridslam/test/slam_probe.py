"""What the node test uses: messages, and waiting for what comes of them, in wall time."""

from __future__ import annotations

import math
import time

import numpy as np
import rosgraph
import rosnode
import rospy
from geometry_msgs.msg import TransformStamped
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

TIMEOUT_S = 30.0  # only those who wait in vain wait so long
BEAMS = 360
ROOM_XY = (5.0, 3.0)
"""m: half the sizes of a room about the origin."""


def wait_until(condition, what: str, timeout_s: float = TIMEOUT_S) -> None:
    deadline = time.monotonic() + timeout_s
    while not condition():
        if time.monotonic() > deadline:
            raise AssertionError(f"waited {timeout_s:.0f} s in vain for {what}")
        time.sleep(0.003)


class Input:
    """A publisher that is known to be connected."""

    def __init__(self, topic, message_type, latch=False):
        self._publisher = rospy.Publisher(topic, message_type, queue_size=50, tcp_nodelay=True, latch=latch)
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

    def last(self, condition, what):
        """Wait until the newest message fulfils the condition, and return it."""
        wait_until(lambda: self.messages and condition(self.messages[-1]), f"{what} on {self._topic}")
        return self.messages[-1]


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


def transform(parent, child, stamp, pose=(0.0, 0.0, 0.0), z=0.0):
    """A transform in the plane, as a TFMessage."""
    message = TransformStamped(child_frame_id=child)
    message.header.stamp, message.header.frame_id = stamp, parent
    t, q = message.transform.translation, message.transform.rotation
    t.x, t.y, t.z = (*pose[:2], z)
    q.z, q.w = math.sin(pose[2] / 2.0), math.cos(pose[2] / 2.0)
    return TFMessage([message])


def room_scan(stamp, pose, frame="laser", beams=BEAMS, **changes):
    """A full turn about ``pose`` in the middle of the room's four walls."""
    scan = LaserScan(range_min=0.1, range_max=20.0)
    scan.header.stamp, scan.header.frame_id = stamp, frame
    scan.angle_min, scan.angle_increment = -math.pi, 2.0 * math.pi / beams
    scan.angle_max = scan.angle_min + (beams - 1) * scan.angle_increment
    bearings = pose[2] + scan.angle_min + scan.angle_increment * np.arange(beams)
    scan.ranges = np.minimum(
        _to_walls(pose[0], np.cos(bearings), ROOM_XY[0]), _to_walls(pose[1], np.sin(bearings), ROOM_XY[1])
    )
    for name, value in changes.items():
        setattr(scan, name, value)
    return scan


def _to_walls(place, directions, half):
    """Distance along each beam to the wall at +half or -half of one axis."""
    with np.errstate(divide="ignore"):
        return np.where(directions > 0.0, half - place, -half - place) / directions
