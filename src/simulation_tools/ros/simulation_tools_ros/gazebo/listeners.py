"""Waits until another node hears what this one says on /rosout."""

from __future__ import annotations

import time
from typing import Callable

import rospy
from rospy.impl.registration import get_topic_manager

LISTENER_S = 60.0
"""Wall time; a node of Python starts in 3 s on a quiet machine."""
LOOK_S = 0.1
ROSOUT = "/rosout"


def wait_for_listener(name: str, should_stop: Callable[[], bool], patience_s: float = LISTENER_S) -> bool:
    """Wait until a node hears this one; return whether it does.

    For a node that must end, but starts faster than the node that writes down why.

    name: of the other node, relative to this one's namespace. patience_s: wall time.
    """
    listener, end_s = rospy.resolve_name(name), time.monotonic() + patience_s
    while not _hears(listener):
        if should_stop() or time.monotonic() >= end_s:
            return False
        rospy.rostime.wallsleep(LOOK_S)
    return True


def _hears(listener: str) -> bool:
    """Whether a node is connected to this one's /rosout."""
    connections = get_topic_manager().get_pub_sub_info()
    return any((node, topic) == (listener, ROSOUT) for _, node, _, _, topic, *_ in connections)
