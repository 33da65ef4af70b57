"""Listens to a graph that starts: a process of its own, begun before roslaunch, that says what came when.

Run as `python -m benchmarks._sim_probe`, with ROS_MASTER_URI set. Each line is a JSON list: name of the
event, monotonic time in seconds. It ends with its standard input.
"""

from __future__ import annotations

import json
import os
import socket
import sys
import time
from urllib.parse import urlparse

import rospy
from geometry_msgs.msg import TwistStamped
from std_msgs.msg import Bool

MASTER_PATIENCE_S = 60.0


class Teller:
    """Prints each event the first time it happens."""

    def __init__(self) -> None:
        self._told: set[str] = set()

    def tell(self, event: str) -> None:
        """Print an event, once."""
        if event not in self._told:
            self._told.add(event)
            print(json.dumps([event, time.monotonic()]), flush=True)


def wait_for_master() -> None:
    """Return when the ROS master answers; TimeoutError after a minute."""
    address = urlparse(os.environ["ROS_MASTER_URI"])
    end = time.monotonic() + MASTER_PATIENCE_S
    while time.monotonic() < end:
        with socket.socket() as sock:
            if sock.connect_ex((address.hostname, address.port)) == 0:
                return
        time.sleep(0.01)
    raise TimeoutError("there is no ROS master")


def main() -> None:
    """Listen until standard input ends."""
    wait_for_master()
    teller = Teller()
    teller.tell("master")
    rospy.init_node("benchmark_probe", disable_signals=True)
    rospy.Subscriber("/UAV/vel_setpoint/safe/body", TwistStamped, lambda _: teller.tell("first_scan_through"))
    for topic, event in (("/UAV/ready", "hovering"), ("/UAV/goal_reached", "goal_reached")):
        rospy.Subscriber(topic, Bool, lambda message, event=event: message.data and teller.tell(event))
    sys.stdin.read()


if __name__ == "__main__":
    main()
