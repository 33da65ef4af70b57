"""An ordinary MAVLink client, and a flight with a link that is stepped together with its clients."""

from __future__ import annotations

import socket

from flight import NO_NOISE, Flight
from pymavlink.dialects.v20 import common as mavlink

from simulation_tools.mavlink import Codec, receive_all, send
from simulation_tools.px4.mavlink.link import MavlinkLink

HOST = "127.0.0.1"
VELOCITY_ONLY = 0b0000_0101_1100_0111  # and a yaw rate
GCS, ONBOARD = 6, 18


class Client:
    """An ordinary MAVLink client."""

    def __init__(self, port, system=255, component=190):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((HOST, 0))
        self.socket.setblocking(False)
        self.to = (HOST, port)
        self.codec = Codec(system, component)
        self.inbox = []

    def send(self, message):
        assert send(self.socket, self.codec.pack(message), self.to)

    def send_raw(self, data):
        assert send(self.socket, data, self.to)

    def heartbeat(self, kind=ONBOARD):
        self.send(mavlink.MAVLink_heartbeat_message(kind, 8, 0, 0, 0, 3))

    def velocity(self, frame=8, mask=VELOCITY_ONLY, stamp=0, system=1, component=1, **fields):
        values = dict.fromkeys(("x", "y", "z", "vx", "vy", "vz", "afx", "afy", "afz", "yaw", "yaw_rate"), 0.0)
        values.update(fields)
        self.send(
            mavlink.MAVLink_set_position_target_local_ned_message(
                stamp, system, component, frame, mask, *values.values()
            )
        )

    def command(self, number, *params, system=1, component=1):
        padded = (*params, *(0.0,) * (7 - len(params)))
        self.send(mavlink.MAVLink_command_long_message(system, component, number, 0, *padded))

    def receive(self):
        for datagram, _ in receive_all(self.socket):
            self.inbox.extend(self.codec.decode(datagram))

    def take(self, kind):
        """Return the received messages of a kind and forget everything."""
        self.receive()
        found = [message for message in self.inbox if message.get_type() == kind]
        self.inbox.clear()
        return found

    def close(self):
        self.socket.close()


class Setup:
    """A flight with a link, stepped together."""

    def __init__(self, flight=None, origin=None):
        self.flight = flight or Flight.of_iris(noise=NO_NOISE, origin=origin)
        self.link = MavlinkLink(self.flight.px4, offboard_port=0, gcs_port=0)
        self.warnings = []
        self.link.on_warning = self.warnings.append
        self.stamps = []
        self.link.on_setpoint = self.stamps.append
        self.clients = []

    def client(self, on_ground_port=False, **identity):
        channel = self.link.ground if on_ground_port else self.link.offboard
        client = Client(channel.port, **identity)
        self.clients.append(client)
        return client

    def run(self, seconds, each=lambda: None):
        for _ in range(round(seconds / 0.004)):
            self.link.poll(self.flight.body.time_us)
            each()
            self.flight.step()
            self.link.send_due(self.flight.body.time_us)
            for client in self.clients:
                client.receive()

    def ack(self, client, act):
        """Do something and return (command, result) of its acknowledgements."""
        client.take("COMMAND_ACK")
        act()
        self.run(0.02)
        return [(ack.command, ack.result) for ack in client.take("COMMAND_ACK")]

    def close(self):
        self.link.close()
        for client in self.clients:
            client.close()
