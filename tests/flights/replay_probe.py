#!/usr/bin/env python3
"""Tell a running CEPA the messages of a recorded flight one by one, and collect what it commands.

usage: replay_probe.py BAG     (needs a ROS master and the node cepa; prints the commands as one JSON line)

Where the bag has a command, the next message waits until CEPA has given one.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Callable
from xmlrpc.client import ServerProxy

import rosbag
import rosgraph
import rospy
from geometry_msgs.msg import TwistStamped

COMMANDS = "/UAV/vel_setpoint/safe/body"
PATIENCE_S = 120.0
"""Wall time: on a busy machine a node takes long to start."""


class Probe:
    """Publishes in step with the node."""

    def __init__(self, messages: list) -> None:
        self.commands: list[tuple] = []
        heard = rospy.Subscriber(COMMANDS, TwistStamped, self._on_command, queue_size=None, tcp_nodelay=True)
        kinds = {topic: type(message) for topic, message, _ in messages if topic != COMMANDS}
        self._publishers = {
            topic: rospy.Publisher(
                topic, kind, queue_size=None, latch=topic == "/tf_static", tcp_nodelay=True
            )
            for topic, kind in kinds.items()
        }
        self._sent = dict.fromkeys(self._publishers, 0)
        ends = [heard, *self._publishers.values()]
        wait_until(lambda: all(end.get_num_connections() for end in ends))
        self._node = ServerProxy(rosgraph.Master("/replay_probe").lookupNode("/cepa"))
        wait_until(self._is_heard)

    def _is_heard(self) -> bool:
        """Whether the node has its end of the connection too: what it says earlier is lost."""
        _, _, (published, _, _) = self._node.getBusStats("/replay_probe")
        return any(connections for topic, _, connections in published if topic == COMMANDS)

    def tell(self, topic: str, message: object) -> None:
        """Publish a message, and wait until the node has taken it."""
        self._publishers[topic].publish(message)
        self._sent[topic] += 1
        wait_until(lambda: self._taken(topic) >= self._sent[topic])

    def _taken(self, topic: str) -> int:
        _, _, (_, subscribed, _) = self._node.getBusStats("/replay_probe")
        return max(
            (c[2] for name, connections in subscribed if name == topic for c in connections), default=0
        )

    def _on_command(self, message: TwistStamped) -> None:
        linear = message.twist.linear
        self.commands.append((message.header.stamp.to_nsec(), linear.x, linear.y, linear.z))


def wait_until(holds: Callable[[], bool], patience_s: float = PATIENCE_S) -> None:
    """Poll with a bounded patience; who waited in vain goes on, and the comparison will tell."""
    end_s = time.monotonic() + patience_s
    while not holds() and time.monotonic() < end_s:
        time.sleep(0.0005)


def main(bag: str) -> int:
    """Replay, and print."""
    rospy.init_node("replay_probe", disable_signals=True)
    with rosbag.Bag(bag) as recorded:
        messages = list(recorded.read_messages())
    probe, expected = Probe(messages), 0
    for topic, message, _ in messages:
        if topic != COMMANDS:
            probe.tell(topic, message)
            continue
        expected += 1
        wait_until(lambda: len(probe.commands) >= expected)  # noqa: B023
        if len(probe.commands) < expected:
            break
    print(json.dumps(probe.commands), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
