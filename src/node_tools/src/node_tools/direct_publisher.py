"""A publisher that sends in the thread that publishes, and never waits for a subscriber.

rospy gives each subscriber of a queued topic a thread of its own. So a message on its way from scan to
setpoint waits for one more thread in each node, and a clock with eight listeners costs the simulator 0.45 ms.
Without a queue, a subscriber that hangs holds up the node. Here the publishing thread itself writes as much
as the socket takes (0.14 ms for the eight). The rest waits for the next message. If too much waits, the
oldest messages are dropped.

Each message wakes its listeners, which push a busy publisher aside on a machine of few cores. A publisher
that holds its messages back sends several at once.
"""

from __future__ import annotations

import contextlib
import socket
from collections import deque
from typing import Any

import rospy
from rospy.exceptions import TransportTerminated


class DirectConnection:
    """Wraps a subscriber's transport as rospy's own queued connection does, without a thread.

    Args:
        connection: rospy's transport to one subscriber.
        queue_size: messages kept for a subscriber that does not read; the oldest are dropped.
        holds: nothing goes out before `flush`.
    """

    def __init__(self, connection: Any, queue_size: int, holds: bool = False) -> None:
        self._connection = connection
        self._holds = holds
        self._rest = b""  # of a message that has been sent in part
        self._waiting: deque[bytes] = deque(maxlen=queue_size)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._connection, name)

    def write_data(self, data: bytes) -> bool:
        """Send one message, or keep it; TransportTerminated when the subscriber has gone."""
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
        """Send what waits, as far as the socket takes it; TransportTerminated when the subscriber is gone."""
        while self._rest or self._waiting:
            if not self._rest:
                self._rest = b"".join(self._waiting)
                self._waiting.clear()
            sent = self._send(self._rest)
            self._rest = self._rest[sent:]
            if self._rest:
                break

    def _send(self, data: bytes) -> int:
        """Return how much of it the socket took."""
        try:
            return self._connection.socket.send(data, socket.MSG_DONTWAIT)
        except BlockingIOError:
            return 0
        except (AttributeError, OSError) as error:  # rospy sets the socket None when it closes it
            self._connection.close()
            raise TransportTerminated(str(error)) from None


class DirectPublisher(rospy.Publisher):
    """A rospy.Publisher whose messages go out in the thread that publishes; for a few kilobytes each.

    A slow subscriber gets the rest with the next message. So use it only for topics that go on.

    Args:
        name: of the topic.
        data_class: of its messages.
        queue_size: messages kept for a slow subscriber; the oldest are dropped.
        holds: messages go out with the next `flush`.
    """

    def __init__(self, name: str, data_class: Any, queue_size: int, holds: bool = False) -> None:
        super().__init__(name, data_class, queue_size=queue_size, tcp_nodelay=True)
        add = self.impl.add_connection
        self.impl.queue_size = None  # or rospy would wrap the connection in its own queue
        self.impl.add_connection = lambda connection: add(DirectConnection(connection, queue_size, holds))

    def flush(self) -> None:
        """Send every subscriber what waits for it."""
        for connection in list(self.impl.connections):
            with contextlib.suppress(TransportTerminated):  # rospy drops it at the next message
                connection.flush()
