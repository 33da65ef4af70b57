#!/usr/bin/env python3
"""Send numbers that are none to each topic that a running node hears. Prints what was sent, as JSON.

usage: nonsense_probe.py NODE ...        (names of nodes that run, such as /cepa)
"""

from __future__ import annotations

import copy
import json
import math
import sys
import time
from typing import Any, Iterator

import rosgraph
import roslib.message
import rospy

NONE = (math.nan, math.inf, -math.inf)
FLOATS = {"float32": 3e38, "float64": 1e308}
"""By type: a number beyond all sense that it can hold."""
FRAMES = {"nav_msgs/Odometry": "odom", "sensor_msgs/LaserScan": "hokuyo", "sensor_msgs/PointCloud2": "hokuyo"}
NOT_OURS = ("/rosout", "/clock", "/tf", "/tf_static")
READY_S, PERIOD_S = 90.0, 0.003

Place = tuple[Any, ...]
"""The way to a number in a message: names of fields, and indices. The number's type comes last."""


def sane(kind: str) -> Any:
    """Return a message of a type, in which all numbers make sense."""
    message = roslib.message.get_message_class(kind)()
    for place in numbers_of(message):
        set_at(message, place, 1.0 if place[-2] == "w" else 0.0)
    if kind == "sensor_msgs/LaserScan":
        message.angle_min, message.angle_increment = -math.pi, math.pi / 180.0
        message.range_min, message.range_max, message.ranges = 0.1, 10.0, [5.0] * 360
    if kind == "sensor_msgs/BatteryState":
        message.percentage, message.voltage = 0.9, 12.0
    if kind == "sensor_msgs/Range":
        message.min_range, message.max_range, message.range = 0.1, 10.0, 2.0
    return message


def numbers_of(message: Any) -> Iterator[Place]:
    """Yield where the real numbers of a message are; of an array, its first number."""
    for name, kind in zip(message.__slots__, message._slot_types):
        value = getattr(message, name)
        element, bracket, _ = kind.partition("[")
        if element in FLOATS and not bracket:
            yield name, element
        elif element in FLOATS:
            if len(value):
                yield name, 0, element
        elif hasattr(value, "__slots__") and kind not in ("time", "duration"):
            yield from ((name, *rest) for rest in numbers_of(value))


def set_at(message: Any, place: Place, number: float) -> None:
    """Put a number into a message."""
    *names, last, _ = place
    if last == 0:
        last = names.pop()
    for name in names:
        message = getattr(message, name)
    is_array = place[-2] == 0
    setattr(message, last, [number, *list(getattr(message, last))[1:]] if is_array else number)


def stamped(message: Any) -> Any:
    """Return the message with the present time, and a frame that exists."""
    if hasattr(message, "header"):
        message.header.stamp = rospy.Time.now()
        message.header.frame_id = FRAMES.get(message._type, "odom")
    if hasattr(message, "child_frame_id"):
        message.child_frame_id = "base_frame"
    return message


def heard_by(node: str) -> dict[str, str]:
    """Return the types of the topics that a node hears, by their names; waits until there are some."""
    master, end_s = rosgraph.Master("/nonsense_probe"), time.monotonic() + READY_S
    while time.monotonic() < end_s:
        _, subscribed, _ = master.getSystemState()
        heard = [topic for topic, nodes in subscribed if node in nodes and topic not in NOT_OURS]
        if heard:
            time.sleep(1.0)  # it may subscribe to more
            _, subscribed, _ = master.getSystemState()
            kinds = dict(master.getTopicTypes())
            return {
                t: kinds[t] for t, nodes in subscribed if node in nodes and t in kinds and t not in NOT_OURS
            }
        time.sleep(0.1)
    return {}


def main(nodes: list[str]) -> None:
    """Send, and tell how many messages each topic of each node got."""
    rospy.init_node("nonsense_probe", disable_signals=True)
    told: dict[str, dict[str, int]] = {}
    for node in nodes:
        told[node] = {}
        for topic, kind in heard_by(node).items():
            publisher = rospy.Publisher(topic, roslib.message.get_message_class(kind), queue_size=1000)
            end_s = time.monotonic() + 60.0
            while not publisher.get_num_connections() and time.monotonic() < end_s:
                time.sleep(0.02)
            base = sane(kind)
            publisher.publish(stamped(copy.deepcopy(base)))
            for place in numbers_of(base):
                for number in (*NONE, FLOATS[place[-1]]):
                    message = copy.deepcopy(base)
                    set_at(message, place, number)
                    publisher.publish(stamped(message))
                    told[node][topic] = told[node].get(topic, 0) + 1
                    time.sleep(PERIOD_S)
            publisher.publish(stamped(base))
    time.sleep(1.0)
    print(json.dumps(told), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
