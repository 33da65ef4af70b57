"""The UDP link on which ArduPilot SITL asks for the state of its vehicle (`--model JSON`).

ArduPilot speaks first. Each of its packets holds the servo outputs of one frame, and it stands still until a
line of JSON answers. After about a second it sends the same frame again. One frame must get one answer,
because ArduPilot reads one answer for each frame: an answer too many would wait in its buffer for ever.
"""

from __future__ import annotations

import struct
import time
from typing import Callable, NamedTuple

from simulation_tools.mavlink import Address, open_udp, receive_all, send, wait_readable

DEFAULT_PORT = 9002
PORT_STEP = 10  # from one instance of ArduPilot to the next
_HEADER = struct.Struct("<HHI")
_CHANNELS = {18458: 16, 29569: 32}  # of each magic number


class ServoFrame(NamedTuple):
    """The outputs of one frame. rate_hz: at which ArduPilot means to run. pulses_us: of all channels."""

    rate_hz: int
    number: int
    pulses_us: tuple[int, ...]


class JsonLink:
    """Listens on `host:port` (0: a free one, see `port`) and answers one ArduPilot.

    `on_warning` is called with a sentence for data that is not ArduPilot's. Raises LinkError if the port is
    not available.
    """

    def __init__(self, port: int = DEFAULT_PORT, host: str = "127.0.0.1") -> None:
        self._socket = open_udp(host, port, "ArduPilot")
        self.port: int = self._socket.getsockname()[1]
        self.on_warning: Callable[[str], None] = lambda sentence: None
        self._waiting: list[ServoFrame] = []
        self.forget()

    def forget(self) -> None:
        """Let another ArduPilot come. What the last one has sent is thrown away."""
        for _ in receive_all(self._socket):
            pass
        self._peer: Address | None = None
        self._newest = -1
        self._waiting.clear()
        self._has_complained = False

    @property
    def connected(self) -> bool:
        """Whether an ArduPilot has sent a frame."""
        return self._peer is not None

    def receive(self, timeout_s: float) -> ServoFrame | None:
        """Return the next frame that no answer was sent to; None if none comes in time (wall time)."""
        end_s = time.monotonic() + timeout_s
        while not self._waiting:
            self._read()
            if not self._waiting and not wait_readable([self._socket], end_s - time.monotonic()):
                return None
        return self._waiting.pop(0)

    def answer(self, line: bytes) -> None:
        """Send the state of the vehicle. Call it once for each frame."""
        if self._peer is not None:
            send(self._socket, line, self._peer)

    def _read(self) -> None:
        for datagram, address in receive_all(self._socket):
            frame = frame_of(datagram)
            if frame is None:
                self._complain(
                    f"received {len(datagram)} bytes that are no servo outputs of ArduPilot Copter 4.6"
                )
            elif self._peer not in (None, address):
                self._complain(
                    f"hears a second ArduPilot, at {address[0]}:{address[1]}; give it a port of its own "
                    "(--sim-port-out)"
                )
            elif frame.number > self._newest:  # not greater: it asks again
                self._peer, self._newest = address, frame.number
                self._waiting.append(frame)

    def _complain(self, what: str) -> None:
        if not self._has_complained:
            self._has_complained = True
            self.on_warning(f"UDP port {self.port} {what}. This is ignored.")

    def close(self) -> None:
        """Release the port."""
        self._socket.close()


def frame_of(datagram: bytes) -> ServoFrame | None:
    """Return the frame that a datagram holds; None if it holds none."""
    if len(datagram) < _HEADER.size:
        return None
    magic, rate_hz, number = _HEADER.unpack_from(datagram)
    channels = _CHANNELS.get(magic, 0)
    if not channels or len(datagram) != _HEADER.size + 2 * channels:
        return None
    return ServoFrame(rate_hz, number, struct.unpack_from(f"<{channels}H", datagram, _HEADER.size))


def check_port_is_free(port: int, host: str = "127.0.0.1") -> None:
    """Raise LinkError if the link could not listen on a port."""
    open_udp(host, port, "ArduPilot").close()
