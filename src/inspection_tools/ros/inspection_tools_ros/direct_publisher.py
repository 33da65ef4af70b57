"""A publisher that sends in the thread that publishes, and never waits for anybody.

rospy gives each subscriber of a queued topic a thread of its own, so that a message on its way from scan to
setpoint waits for one more thread in each node; without a queue a subscriber that hangs would hold up the
node. Here the publishing thread itself writes what the socket takes; what it does not take waits for the next
message, the oldest giving way.
"""

from __future__ import annotations

import socket
from collections import deque

import rospy
from rospy.exceptions import TransportTerminated


class DirectPublisher(rospy.Publisher):
    """A publisher of a stream: what a slow subscriber's socket does not take goes with the next message."""

    def __init__(self, name: str, data_class, queue_size: int):
        super().__init__(name, data_class, queue_size=queue_size, tcp_nodelay=True)
        add = self.impl.add_connection
        self.impl.queue_size = None  # or rospy would wrap the connection in its own queue
        self.impl.add_connection = lambda connection: add(DirectConnection(connection, queue_size))


class DirectConnection:
    """Wraps a subscriber's transport as rospy's own queued connection does, without a thread."""

    def __init__(self, connection, queue_size: int):
        self._connection = connection
        self._rest = b""  # of a message that has been sent in part
        self._waiting: deque[bytes] = deque(maxlen=queue_size)

    def __getattr__(self, name: str):
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._connection, name)

    def write_data(self, data: bytes) -> bool:
        """Send one message, or keep it; TransportTerminated when the subscriber has gone."""
        connection = self._connection
        if connection.done or connection.socket is None:
            raise TransportTerminated("connection closed")
        self._waiting.append(data)
        while self._rest or self._waiting:
            self._rest = self._rest or self._waiting.popleft()
            self._rest = self._rest[self._send(self._rest) :]
            if self._rest:
                break
        connection.stat_bytes += len(data)
        connection.stat_num_msg += 1
        return True

    def _send(self, data: bytes) -> int:
        """Return how much of it the socket took."""
        try:
            return self._connection.socket.send(data, socket.MSG_DONTWAIT)
        except BlockingIOError:
            return 0
        except (AttributeError, OSError) as error:  # rospy sets the socket None when it closes it
            self._connection.close()
            raise TransportTerminated(str(error)) from None
