"""A publisher that sends in the publishing thread and never waits for a subscriber.

For a topic with a queue, rospy gives each subscriber its own thread. So each node on the way from scan to
setpoint adds a wait for one more thread, and a clock with eight subscribers costs the simulator 0.45 ms.
Without a queue, a subscriber that hangs blocks the node. Here the publishing thread itself writes as much as
the socket takes (0.14 ms for the eight). The rest waits for the next message. If too much waits, the oldest
messages are dropped. On a machine with few cores, each message wakes its subscribers, which take the core
from a busy publisher. So a publisher can hold messages back and send several at once.
"""

from __future__ import annotations

import contextlib
import socket
from collections import deque
from typing import Any

import rospy
from rospy.exceptions import TransportTerminated
from rospy.impl.tcpros_pubsub import QueuedConnection


class DirectConnection:
    """Wraps a subscriber's transport like rospy's own queued connection, but without a thread.

    Args:
        connection: rospy's transport to one subscriber.
        queue_size: messages kept for a subscriber that does not read. The oldest are dropped.
        holds: send nothing before `flush`.
    """

    def __init__(self, connection: Any, queue_size: int, holds: bool = False) -> None:
        self._connection = connection
        self._holds = holds
        self._rest = b""  # the rest of a partly sent message
        self._waiting: deque[bytes] = deque(maxlen=queue_size)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._connection, name)

    def write_data(self, data: bytes) -> bool:
        """Send one message, or keep it; TransportTerminated if the subscriber has gone."""
        connection = self._connection
        if connection.done or connection.socket is None:
            raise TransportTerminated("connection closed")
        self._waiting.append(data)
        if not self._holds:
            self.flush()
        connection.stat_bytes += len(data)
        connection.stat_num_msg += 1
        return True

    def flush(self) -> None:
        """Send waiting data as far as the socket takes it; TransportTerminated if the subscriber has gone."""
        while self._rest or self._waiting:
            if not self._rest:
                self._rest = b"".join(self._waiting)
                self._waiting.clear()
            sent = self._send(self._rest)
            self._rest = self._rest[sent:]
            if self._rest:
                break

    def _send(self, data: bytes) -> int:
        """Return how many bytes the socket took."""
        try:
            return self._connection.socket.send(data, socket.MSG_DONTWAIT)
        except BlockingIOError:
            return 0
        except (AttributeError, OSError) as error:  # rospy sets the socket None when it closes it
            self._connection.close()
            raise TransportTerminated(str(error)) from None


class DirectPublisher(rospy.Publisher):
    """A rospy.Publisher that sends in the publishing thread, for messages of a few kilobytes.

    A slow subscriber gets the rest with the next message. So use it only for topics with regular messages.

    Args:
        name: of the topic.
        data_class: of its messages.
        queue_size: messages kept for a slow subscriber. The oldest are dropped.
        holds: send messages only at the next `flush`.
    """

    def __init__(self, name: str, data_class: Any, queue_size: int, holds: bool = False) -> None:
        super().__init__(name, data_class, queue_size=queue_size, tcp_nodelay=True)
        add = self.impl.add_connection
        self.impl.queue_size = None  # or rospy would wrap the connection in its own queue
        self.impl.add_connection = lambda connection: add(DirectConnection(connection, queue_size, holds))
        with self.impl.c_lock:  # a subscriber may have connected before these lines
            self.impl.connections = [
                each
                if isinstance(each, (DirectConnection, QueuedConnection))
                else DirectConnection(each, queue_size, holds)
                for each in self.impl.connections
            ]

    def flush(self) -> None:
        """Send every subscriber its waiting messages."""
        for connection in list(self.impl.connections):
            with contextlib.suppress(TransportTerminated):  # rospy drops it at the next message
                if isinstance(connection, DirectConnection):  # others send by themselves
                    connection.flush()
