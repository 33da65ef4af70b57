"""The TCP link on which PX4 SITL looks for its simulator: MAVLink 2, one PX4 at a time.

PX4 tries to connect until a simulator listens. First it sends a heartbeat and asks for messages. Then it
answers every HIL_SENSOR with one HIL_ACTUATOR_CONTROLS. It never connects twice. When a connection ends, the
link waits until the user has started PX4 again.
"""

from __future__ import annotations

import contextlib
import select
import socket
import time
from typing import Callable

from pymavlink.dialects.v20 import common

from simulation_tools.mavlink import LinkError, why_not_bound

DEFAULT_PORT = 4560
_SYSTEM, _COMPONENT = 1, 200  # the ids that Gazebo's plugin uses
_CHUNK = 65536
_SEND_PATIENCE_S = 1.0  # if PX4 reads nothing for this long, the connection is closed


class SimulatorLink:
    """Listens on `host:port` (0: a free one, see `port`) and talks to the PX4 that connects.

    `on_warning` is called with a sentence when a connection is lost. Raises LinkError if the port is not
    available.
    """

    def __init__(self, port: int = DEFAULT_PORT, host: str = "127.0.0.1") -> None:
        self._server = _open(host, port, listen=True)
        self.port = self._server.getsockname()[1]
        self._peer: socket.socket | None = None
        self._mav = common.MAVLink(None, srcSystem=_SYSTEM, srcComponent=_COMPONENT)
        self.on_warning: Callable[[str], None] = lambda sentence: None
        self.bad = 0

    @property
    def connected(self) -> bool:
        """Whether a PX4 is connected."""
        return self._peer is not None

    def accept(self) -> bool:
        """Accept the connection of a waiting PX4. Return False if there is none. This never blocks."""
        try:
            peer, _ = self._server.accept()
        except OSError:
            return False
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        peer.settimeout(_SEND_PATIENCE_S)
        self._peer = peer
        self._mav = common.MAVLink(None, srcSystem=_SYSTEM, srcComponent=_COMPONENT)
        self._mav.robust_parsing = True
        return True

    def send(self, *messages: common.MAVLink_message) -> None:
        """Send messages together."""
        if self._peer is None:
            return
        packets = bytearray()
        for message in messages:
            packets += message.pack(self._mav)
            self._mav.seq = (self._mav.seq + 1) % 256
        try:
            self._peer.sendall(packets)
        except OSError:
            self._lose()

    def receive(self, timeout_s: float) -> list[common.MAVLink_message]:
        """Return the messages that have arrived; wait at most this long, in wall time, for the first one."""
        end = time.monotonic() + timeout_s
        while self._peer is not None:
            readable, _, _ = select.select([self._peer], [], [], max(end - time.monotonic(), 0.0))
            if not readable:
                return []
            messages = self._read()
            if messages:
                return messages
        return []

    def _read(self) -> list[common.MAVLink_message]:
        data = b""
        with contextlib.suppress(OSError):
            data = self._peer.recv(_CHUNK) if self._peer else b""
        if not data:
            self._lose()
            return []
        messages = self._mav.parse_buffer(data) or []
        good = [message for message in messages if message.get_msgId() >= 0]
        self.bad += len(messages) - len(good)
        return good

    def disconnect(self) -> None:
        """Close the connection, if there is one. Another PX4 may connect then."""
        if self._peer is not None:
            self._peer.close()
            self._peer = None

    def _lose(self) -> None:
        self.disconnect()
        self.on_warning(
            "PX4 has closed its connection to the simulator, and the rotors stop; start PX4 again, "
            f"the simulator waits for it on TCP port {self.port}."
        )

    def close(self) -> None:
        """Close the connection and the port."""
        self.disconnect()
        self._server.close()


def how_to_start(port: int) -> str:
    """Return a sentence on how to start the PX4 that connects to this port."""
    instance = port - DEFAULT_PORT
    if instance == 0:
        return f"Start it: `make px4_sitl none_iris`; it connects to TCP port {port}."
    return f"Start PX4 SITL as instance {instance} (`px4 -i {instance}`); it connects to TCP port {port}."


def check_port_is_free(port: int, host: str = "127.0.0.1") -> None:
    """Raise LinkError if nobody could listen on the port. A PX4 that waits for its simulator notices nothing.

    PX4 never connects twice, so it must not connect to a mere check.
    """
    _open(host, port, listen=False).close()


def _open(host: str, port: int, listen: bool) -> socket.socket:
    server = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        server.bind((host, port))
        if listen:
            server.listen(1)
            server.setblocking(False)
    except (OSError, OverflowError) as error:
        server.close()
        raise LinkError(f"Cannot listen on TCP {host}:{port} for PX4: {why_not_bound(error)}.") from None
    return server
