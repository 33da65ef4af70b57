"""For tests of nodes: sends a message, and waits in wall time for its effect."""

from __future__ import annotations

import os
import threading
import time
import unittest
from functools import partial
from typing import Any, Callable
from xmlrpc.client import ServerProxy

import rosgraph
import rosnode
import rospy
from rosgraph_msgs.msg import Log

TIMEOUT_S = 150.0
"""Only a test that fails waits this long."""
QUIET_S = 0.3
"""Time without messages after which a topic counts as quiet."""

long = unittest.skipIf("WITHOUT_LONG_TESTS" in os.environ, "long")
"""Leaves a test of a rostest to `--all`, as pytest's marker of this name does."""


def wait_until(
    condition: Callable[[], Any], what: str, timeout_s: float = TIMEOUT_S, longest_s: float = 0.1
) -> None:
    """Return when the condition is true; AssertionError if it never is. longest_s: between two looks."""
    start = time.monotonic()
    while not condition():
        waited_s = time.monotonic() - start
        if waited_s > timeout_s:
            raise AssertionError(f"waited {timeout_s:.0f} s in vain for {what}")
        # A condition may ask the master. Asked 100 times a second, it slows down the node that is waited for.
        time.sleep(min(max(0.01, 0.1 * waited_s), longest_s))


def address_of(node: str) -> str | None:
    """Return the XML-RPC address of a node; None while there is no such node."""
    return rosnode.get_api_uri(rosgraph.Master(rospy.get_name()), node, skip_cache=True)


class Input:
    """A publisher that is known to be connected."""

    def __init__(self, topic: str, message_type: Any, latch: bool = False) -> None:
        self._publisher = rospy.Publisher(topic, message_type, queue_size=50, tcp_nodelay=True, latch=latch)
        wait_until(lambda: self._publisher.get_num_connections() > 0, f"a subscriber of {topic}")

    def send(self, message: Any) -> None:
        """Publish a message."""
        self._publisher.publish(message)

    def deliver(self, message: Any) -> None:
        """Publish a message, and return when every subscriber has taken it. Those before are taken already.

        Messages of two topics have no order. Who needs one delivers the first before the second is sent.
        """
        nodes = {connection.endpoint_id for connection in self._publisher.impl.connections}
        before = {node: self._taken_by(node) for node in nodes}
        self.send(message)
        for node in nodes:
            for _ in range(2):  # between two answers of the node, its callback runs
                wait_until(partial(self._has_more, node, before[node]), f"{node} to take a message")

    def _has_more(self, node: str, before: int) -> bool:
        return self._taken_by(node) > before

    def _taken_by(self, node: str) -> int:
        """Return how many messages of this topic a node has read."""
        address = address_of(node)
        if address is None:
            return 0
        answer: Any = ServerProxy(address).getBusStats(rospy.get_name())
        _, _, (_, subscribed, _) = answer
        counts = [counts for topic, counts in subscribed if topic == self._publisher.resolved_name]
        return sum(read for connections in counts for _, _, read, *_ in connections)


class Output:
    """Collects what a node publishes; known to be connected."""

    def __init__(self, topic: str, message_type: Any) -> None:
        self.messages: list[Any] = []
        self._topic, self._came = topic, threading.Condition()
        self._subscriber = rospy.Subscriber(topic, message_type, self._take, tcp_nodelay=True)
        # A node may compile its inner loops first
        wait_until(lambda: self._subscriber.get_num_connections() > 0, f"a publisher of {topic}", 120.0)

    def _take(self, message: Any) -> None:
        with self._came:
            self.messages.append(message)
            self._came.notify_all()

    def _wait_until(self, condition: Callable[[], Any], what: str) -> None:
        """Like `wait_until`, for a condition that only a message changes."""
        with self._came:
            if not self._came.wait_for(condition, TIMEOUT_S):
                raise AssertionError(f"waited {TIMEOUT_S:.0f} s in vain for {what} on {self._topic}")

    def next(self) -> Any:
        """Wait for a message and take it."""
        self._wait_until(lambda: self.messages, "a message")
        return self.messages.pop(0)

    def last(self, condition: Callable[[Any], bool], what: str) -> Any:
        """Wait until the newest message fulfils the condition, and return it."""
        self._wait_until(lambda: self.messages and condition(self.messages[-1]), what)
        return self.messages[-1]

    def holds(self, condition: Callable[[Any], bool], within_s: float) -> bool:
        """Return whether a message fulfils the condition, of those that are here or come so soon."""
        with self._came:
            return self._came.wait_for(lambda: any(map(condition, self.messages)), within_s)

    def assert_quiet(self) -> None:
        """Fail if a message comes within `QUIET_S`."""
        time.sleep(QUIET_S)
        assert not self.messages, f"{self._topic} should be quiet, but said {self.messages[0]}"


class Warned:
    """Collects the warnings of one node; known to hear it."""

    def __init__(self, node: str) -> None:
        self.sentences: list[str] = []
        self._node = node
        self._subscriber = rospy.Subscriber("/rosout", Log, self._on_log)
        wait_until(self._hears_node, f"the log of {node}")

    def _hears_node(self) -> bool:
        """A node is heard only when it is connected to /rosout, which is a topic like others."""
        return address_of(self._node) in [each[1] for each in self._subscriber.impl.get_stats_info()]

    def _on_log(self, log: Log) -> None:
        if log.name == self._node and log.level >= Log.WARN:
            self.sentences.append(log.msg)

    def wait_for(self, text: str) -> None:
        """Wait for a sentence that holds `text`."""
        wait_until(lambda: self.count(text), f'a warning with "{text}" among {self.sentences}')

    def count(self, text: str) -> int:
        """Return how many sentences hold `text`."""
        return sum(text in sentence for sentence in self.sentences)


class Stamps:
    """Stamps that go forward by a lidar's period."""

    def __init__(self, start_s: float = 100.0) -> None:
        self._now = rospy.Time.from_sec(start_s)

    @property
    def now_s(self) -> float:
        """The last stamp."""
        return self._now.to_sec()

    def next(self, step_s: float = 0.025) -> rospy.Time:
        """Return the next stamp."""
        self._now += rospy.Duration.from_sec(step_s)
        return self._now
