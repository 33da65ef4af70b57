"""MAVLink 2 over UDP: the shared part of the flight controller's side and the client's side.

Every datagram is decoded alone, so a bad one cannot spoil the next. Garbage and truncated or corrupted
messages are counted and skipped. Messages of types that are not in the dialect are skipped without counting,
because newer flight controllers send them.
"""

from __future__ import annotations

import contextlib
import errno
import math
import select
import socket
import struct
from typing import Container, Iterator, Sequence

from pymavlink.dialects.v20 import common

from simulation_tools.bounds import FLOAT32_MAX, fit_float32
from simulation_tools.errors import SimulationToolsError

Address = tuple[str, int]
MAGIC_V1, MAGIC_V2 = 0xFE, 0xFD
_OVERHEAD_V1, _OVERHEAD_V2, _SIGNATURE = 8, 12, 13
_SIGNED = 1  # the only incompatibility flag that MAVLink 2 has
_MAX_DATAGRAM = 65535
_WAKE_RADIO = b"0 "
"""ArduPilot writes it on each link when it starts, against SiK radios that hang (GCS_MAVLINK::init)."""


class LinkError(SimulationToolsError):
    """A MAVLink link cannot be opened."""


class Codec:
    """Packs and decodes messages for one sender identity.

    bad: number of pieces that are no message. unknown: number of messages of unknown types. wanted: numbers
    of the types that `decode` yields; None: all. unwanted: number of the other messages. They are only
    checked, because unpacking takes longer than all the rest.
    """

    def __init__(self, system_id: int, component_id: int) -> None:
        self.system_id = system_id
        self.component_id = component_id
        self._mav = common.MAVLink(None, srcSystem=system_id, srcComponent=component_id)
        self.bad = 0
        self.unknown = 0
        self.unwanted = 0
        self.wanted: set[int] | None = None

    @property
    def identity(self) -> tuple[int, int]:
        """System and component id."""
        return self.system_id, self.component_id

    def pack(self, message: common.MAVLink_message) -> bytes:
        """Return the message's bytes, with the next sequence number.

        A number beyond float32 becomes infinite, as in PX4, whose numbers are float32.
        """
        try:
            packet = message.pack(self._mav)
        except OverflowError:
            _narrow(message)
            packet = message.pack(self._mav)
        self._mav.seq = (self._mav.seq + 1) % 256
        return bytes(packet)

    def decode(self, datagram: bytes) -> Iterator[common.MAVLink_message]:
        """Yield the messages of a datagram."""
        start, end = 0, len(datagram)
        while datagram.startswith(_WAKE_RADIO, start):
            start += len(_WAKE_RADIO)
        while start < end:
            length = _frame_length(datagram, start)
            message = None
            if self.wanted is not None and _is_other(datagram, start, start + length, self.wanted):
                self.unwanted += 1
                start += length
                continue
            if length and start + length <= end:
                # pymavlink raises MAVError on most bad frames; the others come from absurd lengths.
                with contextlib.suppress(common.MAVError, struct.error, IndexError, ValueError):
                    message = self._mav.decode(bytearray(datagram[start : start + length]))
            if message is not None and message.get_msgId() >= 0:
                yield message
                start += length
            elif _is_unknown(datagram, start, start + length):
                self.unknown += 1
                start += length
            else:
                self.bad += 1
                start = _next_magic(datagram, start + 1)


def _narrow(message: common.MAVLink_message) -> None:
    """Make the numbers of a message infinite that float32 cannot hold."""
    for name, kind in zip(message.fieldnames, message.fieldtypes):
        value = getattr(message, name)
        if kind == "float":
            is_array = isinstance(value, (list, tuple))
            setattr(message, name, [_narrowed(v) for v in value] if is_array else _narrowed(value))


def _narrowed(value: float) -> float:
    return math.copysign(math.inf, value) if abs(value) > FLOAT32_MAX else value


def _frame_length(data: bytes, start: int) -> int:
    """Return the length of the message that seems to start here; 0 if there is none."""
    if len(data) - start < 3:
        return 0
    if data[start] == MAGIC_V1:
        return _OVERHEAD_V1 + data[start + 1]
    if data[start] == MAGIC_V2:
        return _OVERHEAD_V2 + data[start + 1] + (_SIGNATURE if data[start + 2] & _SIGNED else 0)
    return 0


def _is_other(data: bytes, start: int, end: int, wanted: Container[int]) -> bool:
    """Whether a sound, unsigned MAVLink 2 message of a known type that is not wanted fills this place."""
    if end - start < _OVERHEAD_V2 or end > len(data) or data[start] != MAGIC_V2 or data[start + 2]:
        return False
    number = int.from_bytes(data[start + 7 : start + 10], "little")
    known = common.mavlink_map.get(number)
    if known is None or number in wanted:
        return False
    checked = common.x25crc(data[start + 1 : end - 2])
    checked.accumulate(bytes((known.crc_extra,)))
    return checked.crc == int.from_bytes(data[end - 2 : end], "little")


def _is_unknown(data: bytes, start: int, end: int) -> bool:
    """Whether a message of a type that is not in the dialect lies between `start` and `end`.

    Without the type its checksum cannot be tested. So the rest must be empty or look like a message. Else
    this may be garbage that hides good messages.
    """
    if end == start or end > len(data) or (end < len(data) and data[end] not in (MAGIC_V1, MAGIC_V2)):
        return False
    if data[start] == MAGIC_V1:
        return data[start + 5] not in common.mavlink_map
    number = int.from_bytes(data[start + 7 : start + 10], "little")
    return data[start + 2] in (0, _SIGNED) and number not in common.mavlink_map


def _next_magic(data: bytes, start: int) -> int:
    """Return where the next start byte is, or the end."""
    places = [place for place in (data.find(MAGIC_V1, start), data.find(MAGIC_V2, start)) if place >= 0]
    return min(places) if places else len(data)


def open_udp(host: str, port: int, purpose: str) -> socket.socket:
    """Bind a non-blocking UDP socket; port 0 takes a free one. Raises LinkError with one sentence."""
    udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        udp.setblocking(False)
        udp.bind((host, port))
    except (OSError, OverflowError) as error:
        udp.close()
        raise LinkError(f"Cannot bind UDP {host}:{port} for {purpose}: {why_not_bound(error)}.") from None
    return udp


def why_not_bound(error: OSError | OverflowError) -> str:
    """Return why a port is not available, and what to do about it."""
    number = getattr(error, "errno", None)
    if number == errno.EADDRINUSE:
        advice = "stop the program that uses the port (another simulator?) or choose another port"
    elif number == errno.EADDRNOTAVAIL:
        advice = "choose an address of this machine"
    else:
        advice = "choose a port from 1024 to 65535"
    return f"{getattr(error, 'strerror', None) or error}; {advice}"


def receive_all(udp: socket.socket) -> Iterator[tuple[bytes, Address]]:
    """Yield the datagrams that have arrived, without waiting."""
    while True:
        try:
            yield udp.recvfrom(_MAX_DATAGRAM)
        except BlockingIOError:
            return
        except ConnectionError:
            continue  # no program received an earlier datagram
        except OSError:
            return  # closed


def send(udp: socket.socket, packet: bytes, address: Address) -> bool:
    """Send a datagram. Return False if the system refuses it (full buffer, no receiver)."""
    try:
        udp.sendto(packet, address)
    except OSError:
        return False
    return True


def wait_readable(sockets: Sequence[socket.socket], timeout_s: float) -> bool:
    """Wait, in wall time, until one of the sockets has something to read."""
    with contextlib.suppress(OSError, ValueError):
        return bool(select.select(sockets, [], [], max(timeout_s, 0.0))[0])
    return False


def decode_text(value: bytes | str) -> str:
    """Return a MAVLink char array as text, whatever bytes it holds."""
    raw = value if isinstance(value, bytes) else value.encode("utf-8", "replace")
    return raw.split(b"\0")[0].decode("utf-8", "replace")


# Parameters travel in a float's four bytes: PX4 puts the bits of an integer there.


def parameter_to_wire(value: float, is_integer: bool) -> float:
    """Return the float whose bits carry a parameter's value; raises ValueError for one out of range."""
    if not (-(2**31) <= value < 2**31 if is_integer else fit_float32([value])):
        raise ValueError(f"{value} is not a 32-bit {'integer' if is_integer else 'number'}")
    return struct.unpack("<f", struct.pack("<i", int(value)))[0] if is_integer else float(value)


def parameter_from_wire(value: float, kind: int) -> float | int:
    """Return a parameter's value. kind: MAV_PARAM_TYPE. Raises ValueError for a type that PX4 lacks."""
    if kind == common.MAV_PARAM_TYPE_INT32:
        return struct.unpack("<i", struct.pack("<f", value))[0]
    if kind == common.MAV_PARAM_TYPE_REAL32:
        return value
    raise ValueError(f"PX4 has no parameters of MAVLink type {kind}")
