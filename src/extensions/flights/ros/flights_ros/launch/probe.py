"""Listens to a starting graph in a separate process, started before roslaunch, and prints events.

Run as `python -m flights_ros.launch.probe EVENT ...`, with ROS_MASTER_URI set. Each line is a JSON
list: name of the event, monotonic time in seconds. It ends with its standard input.
"""

from __future__ import annotations

import json
import os
import socket
import sys
import threading
import time
from typing import Sequence
from urllib.parse import urlparse

import rosgraph
import rospy
from geometry_msgs.msg import TwistStamped
from mavros_msgs.msg import State
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool

MASTER_PATIENCE_S = 60.0
EVENTS = {
    "first_scan": ("/scan", LaserScan, lambda scan: True),
    "flight_controller": ("/mavros/state", State, lambda state: state.connected),
    "first_scan_through": ("/UAV/vel_setpoint/safe/body", TwistStamped, lambda velocity: True),
    "hovering": ("/UAV/ready", Bool, lambda ready: ready.data),
    "goal_reached": ("/UAV/goal_reached", Bool, lambda reached: reached.data),
}
"""Name to topic, type, and a test whether a message is the event."""
RVIZ = "rviz"
"""The event that RViz has subscribed to its displays' topics, so its window is open."""
COMMON_TOPICS = ("/clock", "/tf", "/tf_static")


class Teller:
    """Prints the first occurrence of each event."""

    def __init__(self) -> None:
        self._told: set[str] = set()

    def tell(self, event: str) -> None:
        """Print an event, once."""
        if event not in self._told:
            self._told.add(event)
            print(json.dumps([event, time.monotonic()]), flush=True)


def wait_for_master() -> None:
    """Wait until the ROS master answers; TimeoutError after a minute."""
    address = urlparse(os.environ["ROS_MASTER_URI"])
    end = time.monotonic() + MASTER_PATIENCE_S
    while time.monotonic() < end:
        with socket.socket() as sock:
            if sock.connect_ex((address.hostname, address.port)) == 0:
                return
        time.sleep(0.01)
    raise TimeoutError("there is no ROS master")


def listen(teller: Teller, event: str) -> None:
    """Subscribe to an event's topic."""
    topic, kind, is_it = EVENTS[event]
    rospy.Subscriber(topic, kind, lambda message: teller.tell(event) if is_it(message) else None)


def watch_for_rviz(teller: Teller) -> None:
    """Wait until RViz subscribes to a display's topic."""
    master = rosgraph.Master("/launch_probe")
    while True:
        _, subscribers, _ = master.getSystemState()
        if any(f"/{RVIZ}" in nodes for topic, nodes in subscribers if topic not in COMMON_TOPICS):
            teller.tell(RVIZ)
            return
        time.sleep(0.05)


def main(events: Sequence[str]) -> None:
    """Listen until standard input ends."""
    wait_for_master()
    teller = Teller()
    teller.tell("master")
    rospy.init_node("launch_probe", disable_signals=True)
    for event in events:
        if event == RVIZ:
            threading.Thread(target=watch_for_rviz, args=(teller,), daemon=True).start()
        else:
            listen(teller, event)
    sys.stdin.read()


if __name__ == "__main__":
    main(sys.argv[1:])
