"""Who is in charge of pos_setpoint: several nodes send it, one after the other.

A `Pose` does not tell its time. A node that latches sends its last one to each new listener. So a position
controller that starts again would get the last one of each node, in any order.
"""

from __future__ import annotations

import time
from typing import Any, Callable

import rosgraph
import rospy
from geometry_msgs.msg import Pose

from flight_basics.errors import ContradictionError
from node_tools.restarts.kept_parameter import KeptParameter

TOPIC = "pos_setpoint"
FIRST_S = 10.0
"""Wall time after a node's start in which it hears what others had sent before."""


class EarlierMessages:
    """Tells what comes only because this node has begun to listen. Make it before the subscriber.

    Args:
        topic: whose senders are asked for.
    """

    def __init__(self, topic: str) -> None:
        published = rosgraph.Master(rospy.get_name()).getSystemState()[0]
        name = rospy.resolve_name(topic)
        self._silent = {node for each, nodes in published if each == name for node in nodes}
        self._until_s = time.monotonic() + FIRST_S

    def has(self, message: Any) -> bool:
        """Whether a message was sent before this node's start: the first one of a node that ran already."""
        sender = sender_of(message)
        was_silent = sender in self._silent
        self._silent.discard(sender)
        return was_silent and time.monotonic() < self._until_s


class SetpointSender(rospy.SubscribeListener):
    """Publishes pos_setpoint. It is in charge from its own setpoint until another node sends one.

    While it is in charge, a new listener gets the last setpoint at once. Afterwards nobody gets it.
    """

    def __init__(self) -> None:
        super().__init__()
        self._last: Pose | None = None
        self._earlier = EarlierMessages(TOPIC)
        self._publisher = rospy.Publisher(TOPIC, Pose, queue_size=1, subscriber_listener=self)
        self._subscriber = rospy.Subscriber(TOPIC, Pose, self._on_setpoint, queue_size=10)

    def send(self, setpoint: Pose) -> None:
        """Publish a setpoint, and take charge."""
        self._last = setpoint
        self._publisher.publish(setpoint)

    def peer_subscribe(self, topic: str, subscriber: str, publish: Callable[[Pose], None]) -> None:
        """Send the last setpoint to a new listener."""
        last = self._last
        if last is not None:
            publish(last)

    def _on_setpoint(self, setpoint: Pose) -> None:
        if sender_of(setpoint) != rospy.get_name() and not self._earlier.has(setpoint):
            self._last = None


class SetpointsInCharge:
    """Tells a listener which setpoints count. Make it before the subscriber.

    A node of this workspace sends its last setpoint to a new listener only while it is in charge. Others may
    latch it, and go on to send it. So a latched setpoint from before the start counts only if no other node's
    is known. A listener that died still knows, by its parameter ~obeys, whom it obeyed.
    """

    def __init__(self) -> None:
        self._earlier = EarlierMessages(TOPIC)
        self._kept = KeptParameter("~obeys")
        self._obeyed = str(self._kept.values.get("sender", ""))
        self._is_sure = bool(self._obeyed)

    def count(self, setpoint: Pose) -> bool:
        """Whether a setpoint counts.

        Raises:
            ContradictionError: several nodes had latched one, and none is known to be the newest.
        """
        sender = sender_of(setpoint)
        is_latched = setpoint._connection_header.get("latching") == "1"
        is_old = self._earlier.has(setpoint) and is_latched
        if is_old and self._obeyed not in ("", sender):
            if self._is_sure:
                return False
            raise ContradictionError(
                f"{self._obeyed} and {sender} had both sent a setpoint before this node started, and it is "
                "not known which is newer. The UAV hovers; send the setpoint again."
            )
        self._is_sure = self._is_sure or not is_old
        if sender != self._obeyed:
            self._obeyed = sender
            self._kept.keep({"sender": sender})
        return True


def sender_of(message: Any) -> str:
    """Return the name of the node that sent a message."""
    return str(message._connection_header.get("callerid", ""))
