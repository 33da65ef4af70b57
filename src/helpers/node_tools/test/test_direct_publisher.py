"""Messages sent by the publishing thread itself: whole, in order, and never waiting for a subscriber."""

from __future__ import annotations

import socket
import struct
import threading
from types import SimpleNamespace

import pytest

pytest.importorskip("rospy", reason="needs ROS")

from rospy.exceptions import TransportTerminated

from node_tools import direct_publisher
from node_tools.direct_publisher import DirectConnection, DirectPublisher

pytestmark = pytest.mark.ros


def send_many(connection):
    for number in range(10):
        connection.write_data(message(number))


class Transport:
    """What rospy's TCPROSTransport has of it."""

    def __init__(self, sock):
        self.socket, self.done = sock, False
        self.stat_bytes = self.stat_num_msg = 0
        self.endpoint_id = "somebody"

    def close(self):
        self.done = True
        self.socket.close()


@pytest.fixture
def pair():
    """A connection that keeps three messages, and the subscriber's end of it."""
    ours, theirs = socket.socketpair()
    connection = DirectConnection(Transport(ours), 3)
    yield connection, Reader(theirs)
    ours.close()
    theirs.close()


def message(number, size=1000):
    return struct.pack("<II", size, number) + bytes(size - 4)


class Reader:
    """The subscriber's end: `read` returns the numbers of the messages that are there (or of that many)."""

    def __init__(self, sock):
        self._socket, self._data = sock, b""
        sock.settimeout(0.2)

    def read(self, count=None):
        numbers = []
        while count is None or len(numbers) < count:
            try:
                self._data += self._socket.recv(65536)
            except TimeoutError:
                break
            while len(self._data) >= 8 and len(self._data) >= 4 + struct.unpack_from("<I", self._data)[0]:
                size, number = struct.unpack_from("<II", self._data)
                numbers.append(number)
                self._data = self._data[4 + size :]
        return numbers


def test_messages_arrive_whole_and_in_order(pair):
    connection, reader = pair
    for number in range(50):
        connection.write_data(message(number))
        assert reader.read(1) == [number]
    assert connection.stat_num_msg == 50
    assert connection.endpoint_id == "somebody"


def test_a_subscriber_that_hangs_holds_nobody_up_and_later_gets_the_newest(pair):
    connection, reader = pair
    for number in range(5000):
        connection.write_data(message(number))  # 5 MB, of which the socket takes a twentieth
    first = reader.read()
    assert first == list(range(len(first)))  # what the socket had taken
    assert len(first) < 4000
    connection.write_data(message(5000))
    late = reader.read()
    # The one that had gone out in part, and the newest three: nothing torn, nothing twice.
    assert late == [len(first), 4998, 4999, 5000]


def test_messages_that_are_held_back_go_out_together(pair):
    connection, reader = pair
    holding = DirectConnection(connection, 3, holds=True)
    for number in range(5):
        holding.write_data(message(number))
    assert reader.read() == []
    holding.flush()
    assert reader.read() == [2, 3, 4]  # as many as it keeps
    holding.flush()
    assert reader.read() == []


def test_a_subscriber_that_has_gone_is_told_of(pair):
    connection, reader = pair
    reader._socket.close()
    with pytest.raises(TransportTerminated):
        send_many(connection)
    assert connection.done
    with pytest.raises(TransportTerminated):
        connection.write_data(message(11))


def test_what_was_held_back_for_one_that_has_gone_meanwhile_is_no_error(pair):
    transport = pair[0]._connection
    holding = DirectConnection(transport, 3, holds=True)
    holding.write_data(message(1))
    transport.socket.close()
    transport.socket = None
    transport.close = lambda: None
    with pytest.raises(TransportTerminated):
        holding.flush()


class QueuedConnection:
    """As rospy's: it sends by its own thread."""


def test_subscribers_that_connect_while_the_publisher_begins_are_served(monkeypatch):
    """rospy's publisher takes connections as soon as it is made, before it is changed to send directly."""
    ours, theirs = socket.socketpair()
    impl = SimpleNamespace(
        c_lock=threading.RLock(), connections=[Transport(ours), QueuedConnection()], add_connection=None
    )
    monkeypatch.setattr(direct_publisher, "QueuedConnection", QueuedConnection)
    monkeypatch.setattr(
        direct_publisher.rospy.Publisher, "__init__", lambda self, *_, **__: setattr(self, "impl", impl)
    )
    monkeypatch.setattr(direct_publisher.rospy.Publisher, "__del__", lambda self: None, raising=False)
    publisher = DirectPublisher("clock", None, queue_size=3, holds=True)
    publisher.flush()
    publisher.impl.connections[0].write_data(message(7))
    reader = Reader(theirs)
    assert reader.read() == []  # held back
    publisher.flush()
    assert reader.read(1) == [7]
    theirs.close()
    ours.close()
