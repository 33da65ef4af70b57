"""One UDP port of the flight controller with the clients on it and the messages streamed to them."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Callable, Iterator, Mapping

from pymavlink.dialects.v20 import common

from simulation_tools.mavlink import Address, Codec, open_udp, receive_all, send
from simulation_tools.px4.mavlink import telemetry
from simulation_tools.px4.mavlink.clock_sync import ClockSync
from simulation_tools.px4.px4 import Px4

_FORGET_PEER_AFTER_S = 10.0  # wall time
_MAX_PEERS = 16
_MAX_DATAGRAM = 280  # bytes, PX4's; MAVROS reads 296 of a datagram and drops the rest


@dataclass
class Peer:
    """A client that has sent a heartbeat. heard_s: wall time."""

    heard_s: float
    is_ground_station: bool = False


@dataclass
class Stream:
    """A message sent at a rate of simulation time; period 0: not at all."""

    period_us: int
    due_us: int = 0


class Channel:
    """Sends to its default remote, if it has one, and to every client that sends heartbeats.

    `clock`: of its clients. `holds`: streamed messages wait for `flush`, so that several instants need few
    datagrams.
    """

    def __init__(
        self,
        px4: Px4,
        host: str,
        local_port: int,
        remote_port: int | None,
        rates_hz: Mapping[str, float],
        streams_unasked: bool,
        purpose: str,
    ) -> None:
        """Open the port.

        remote_port: where heartbeats go before a client has spoken, 0: nowhere. streams_unasked: the other
        messages go there too.
        """
        self._px4 = px4
        self._default_rates_hz = dict(rates_hz)
        self._remote: Address | None = (host, remote_port) if remote_port else None
        self._streams_unasked = streams_unasked
        self._peers: dict[Address, Peer] = {}
        self._streams = {name: Stream(round(1e6 / rate)) for name, rate in rates_hz.items()}
        self._next_due_us = 0
        self._heartbeat_content: tuple | None = None
        self._home: object = None  # the last one that was streamed
        self.clock = ClockSync()
        self.holds = False
        self._held: list[common.MAVLink_message] = []
        self.codec = Codec(int(px4.parameters["MAV_SYS_ID"]), int(px4.parameters["MAV_COMP_ID"]))
        self.socket = open_udp(host, local_port, purpose)

    @property
    def port(self) -> int:
        """The local port."""
        return self.socket.getsockname()[1]

    def reset(self) -> None:
        """Start all streams again, as simulation time does."""
        self._next_due_us = 0
        self._held.clear()
        self.clock = ClockSync()
        for stream in self._streams.values():
            stream.due_us = 0

    def receive(self, until: Callable[[], bool]) -> Iterator[tuple[common.MAVLink_message, Address]]:
        """Yield every message with its sender. Stop early if `until` returns True after a datagram."""
        for datagram, address in receive_all(self.socket):
            for message in self.codec.decode(datagram):
                yield message, address
            if until():
                return

    def heard(self, address: Address, is_ground_station: bool) -> None:
        """Note a client's heartbeat."""
        now_s = time.monotonic()
        if address not in self._peers and len(self._peers) >= _MAX_PEERS:
            return
        self._peers[address] = Peer(now_s, is_ground_station)

    def reply(self, message: common.MAVLink_message, address: Address) -> None:
        """Send a message to one client."""
        send(self.socket, self.codec.pack(message), address)

    def send_to_ground_stations(self, message: common.MAVLink_message) -> None:
        """Send a message to every client that calls itself a ground station."""
        addresses = [address for address, peer in self._peers.items() if peer.is_ground_station]
        if addresses:
            self._send(self.codec.pack(message), addresses)

    def send_to_peers(self, messages: list[common.MAVLink_message]) -> None:
        """Send messages to all clients, and to the default remote if it gets streams unasked."""
        if messages and (self._peers or self._streams_unasked):
            self._send_together(messages, self._addresses())

    def send_due(self, time_us: int) -> None:
        """Send the streamed messages that are due at a simulation time, or keep them for `flush`."""
        if time_us < self._next_due_us:
            return
        addresses = self._addresses()
        everything = bool(self._peers) or self._streams_unasked
        status = self._px4.status if addresses else None
        if status is not None and status.heartbeat_content != self._heartbeat_content:
            self._heartbeat_content = status.heartbeat_content
            self._streams["HEARTBEAT"].due_us = time_us  # a change is sent at once
        if self._px4.home is not self._home:
            self._home = self._px4.home
            self._streams["HOME_POSITION"].due_us = time_us
        messages = []
        for name, stream in self._streams.items():
            if not stream.period_us or time_us < stream.due_us:
                continue
            # Keep the phase of the stream, but do not catch up after a pause.
            late = time_us - stream.due_us >= stream.period_us
            stream.due_us = time_us + stream.period_us if late else stream.due_us + stream.period_us
            if status is not None and (everything or name == "HEARTBEAT"):
                message = telemetry.build(name, self._px4, status)
                if message is not None:
                    messages.append(message)
        if self.holds:
            self._held += messages
        else:
            self._send_together(messages, addresses)
        periodic = [stream.due_us for stream in self._streams.values() if stream.period_us]
        self._next_due_us = min(periodic, default=time_us)

    def flush(self) -> None:
        """Send the messages that were kept."""
        if self._held:
            held, self._held = self._held, []
            self._send_together(held, self._addresses())

    def interval_us(self, name: str) -> int:
        """Return the interval at which a message is streamed; 0: not at all."""
        stream = self._streams.get(name)
        return stream.period_us if stream else 0

    def set_interval(self, name: str, interval_us: float) -> bool:
        """Change a rate: > 0 interval, 0 the default, -1 stop. Return False if PX4 would refuse."""
        if name == "HEARTBEAT" or not interval_us <= 1e9:
            return False
        if not telemetry.can_build(name):
            return name in telemetry.SILENT
        if interval_us == 0:
            default = self._default_rates_hz.get(name)
            interval_us = 1e6 / default if default else -1
        stream = self._streams.setdefault(name, Stream(0))
        stream.period_us = max(round(interval_us), 1000) if interval_us > 0 else 0
        stream.due_us = self._next_due_us = 0
        return True

    def close(self) -> None:
        """Release the port."""
        self.socket.close()

    def _addresses(self) -> list[Address]:
        """Return the receivers, and forget clients that are silent."""
        now_s = time.monotonic()
        for address in [a for a, p in self._peers.items() if now_s - p.heard_s > _FORGET_PEER_AFTER_S]:
            del self._peers[address]
        addresses = list(self._peers)
        if self._remote is not None and self._remote not in self._peers:
            addresses.append(self._remote)
        return addresses

    def _send_together(self, messages: list[common.MAVLink_message], addresses: list[Address]) -> None:
        """Send messages of one instant in few datagrams, because each datagram wakes its receiver."""
        datagram = b""
        for packet in map(self.codec.pack, messages):
            if len(datagram) + len(packet) > _MAX_DATAGRAM:
                self._send(datagram, addresses)
                datagram = b""
            datagram += packet
        if datagram:
            self._send(datagram, addresses)

    def _send(self, datagram: bytes, addresses: list[Address]) -> None:
        for address in addresses:
            send(self.socket, datagram, address)
