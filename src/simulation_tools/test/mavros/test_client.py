"""The client against the flight controller's link over real UDP; the other side is stepped by a thread."""

from __future__ import annotations

import contextlib
import socket
import threading
import time

import pytest
from flight import NO_NOISE, Flight
from lossy_proxy import LossyProxy
from pymavlink.dialects.v20 import common

from simulation_tools.mavlink import Codec
from simulation_tools.mavros.client import FcuClient
from simulation_tools.mavros.mode_names import custom_mode, mode_name
from simulation_tools.px4.mavlink.link import MavlinkLink


class FlightController(threading.Thread):
    """Steps a flight and its link about in real time, until told to stop; `paused` stops its clock."""

    def __init__(self):
        super().__init__(daemon=True)
        self.flight = Flight.of_iris(noise=NO_NOISE)
        self.link = MavlinkLink(self.flight.px4, 0, 0)
        self.running = True

    def run(self):
        while self.running:
            self.link.poll(self.flight.body.time_us)
            self.flight.step()
            self.link.send_due(self.flight.body.time_us)
            self.link.wait(0.002)

    def stop(self):
        self.running = False
        self.join(5.0)
        self.link.close()


@pytest.fixture
def pair():
    """(client, flight controller), both served by threads."""
    fcu = FlightController()
    client = FcuClient(
        f"udp://127.0.0.1:0@127.0.0.1:{fcu.link.offboard.port}",
        connection_timeout_s=1.0,
        command_timeout_s=30.0,
    )
    fcu.start()
    stop = threading.Event()

    def serve():
        while not stop.is_set():
            client.wait(0.02)
            client.poll()

    server = threading.Thread(target=serve, daemon=True)
    server.start()
    client.send_heartbeat()
    yield client, fcu
    stop.set()
    server.join(5.0)
    fcu.stop()
    client.close()


def eventually(condition, timeout_s=60.0):
    end = time.monotonic() + timeout_s
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.01)
    return False


def test_it_connects_and_notices_the_loss(pair):
    client, fcu = pair
    assert eventually(lambda: client.connected)
    fcu.stop()
    assert eventually(lambda: not client.connected)


def test_commands_are_answered_or_time_out(pair):
    client, fcu = pair
    assert eventually(lambda: fcu.flight.px4.home is not None)
    assert client.command(400, 1.0) == 0
    assert fcu.flight.px4.status.armed
    assert client.command(31000) == 3
    fcu.stop()
    client._command_timeout_s = 0.5
    began = time.monotonic()
    assert client.command(400, 0.0) is None
    assert time.monotonic() - began >= 0.5


def test_parameters_are_read_set_and_pulled(pair):
    client, fcu = pair
    assert client.get_parameter("MPC_XY_P") == pytest.approx(0.95)
    assert client.get_parameter("COM_OBL_ACT") == 0
    assert isinstance(client.get_parameter("COM_OBL_ACT"), int)
    assert client.set_parameter("MPC_XY_P", 1.25) == 1.25
    assert fcu.flight.px4.parameters["MPC_XY_P"] == 1.25
    assert client.set_parameter("MPC_XY_P", 99.0) == 1.25
    assert client.get_parameter("NO_SUCH") is None
    assert len(client.pull_parameters()) == len(fcu.flight.px4.parameters)


def test_parameters_come_over_a_network_that_loses_a_fifth(pair):
    _, fcu = pair
    proxy = LossyProxy(fcu.link.offboard.port, seed=5)
    client = FcuClient(f"udp://127.0.0.1:0@127.0.0.1:{proxy.port}")
    stop = threading.Event()

    def serve():
        while not stop.is_set():
            proxy.pump()
            client.wait(0.002)
            client.poll()

    server = threading.Thread(target=serve, daemon=True)
    server.start()
    client.send_heartbeat()
    assert len(client.pull_parameters()) == len(fcu.flight.px4.parameters)
    # The client gives up after 3 s of wall time, in which a loaded machine may have lost every answer.
    for _ in range(5):
        told = (client.get_parameter("MPC_XY_P") for _ in range(3))
        assert next(value for value in told if value is not None) == pytest.approx(0.95)
    # A late answer to an earlier question may be taken for this one's.
    assert any(client.set_parameter("MPC_XY_P", 1.25) == 1.25 for _ in range(3))
    stop.set()
    server.join(5.0)
    client.close()
    proxy.close()


@pytest.mark.parametrize(
    ("name", "value"), [("MPC_XY_P", 1e300), ("MPC_XY_P", float("nan")), ("COM_OBL_ACT", 2**31)]
)
def test_parameters_that_mavlink_cannot_carry_are_refused(pair, name, value):
    client, _ = pair
    with pytest.raises(ValueError, match="32-bit"):
        client.set_parameter(name, value)


def test_commands_take_nan_for_not_given_but_no_absurd_numbers(pair):
    client, _ = pair
    assert client.command(31000, float("nan")) == 3
    with pytest.raises(ValueError, match="31000"):
        client.command(31000, 1e308)


@pytest.mark.parametrize(
    ("component", "kind", "autopilot"),
    [(1, common.MAV_TYPE_GCS, 12), (1, 2, common.MAV_AUTOPILOT_INVALID), (190, 2, 12)],
)
def test_only_an_autopilot_of_the_target_can_take_the_link_over(pair, component, kind, autopilot):
    """A script that gives itself system 1, as most do, talks to the client's port."""
    client, _ = pair
    assert eventually(lambda: client.connected)
    stranger = Codec(1, component)
    heard = []
    client.on("STATUSTEXT", heard.append)
    messages = [
        common.MAVLink_heartbeat_message(kind, autopilot, 0, 0, 4, 3),
        common.MAVLink_statustext_message(6, b"I am not the flight controller"),
    ]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        for _ in range(10):
            for message in messages:
                udp.sendto(stranger.pack(message), ("127.0.0.1", client.port))
            time.sleep(0.01)
        assert client.get_parameter("MPC_XY_P") == pytest.approx(0.95)
        time.sleep(0.1)
    assert not [m for m in heard if "not the flight controller" in m.text]


def test_an_autopilot_on_another_host_cannot_take_the_link_over(pair):
    """The client listens on every network; the URL says on which host the flight controller is."""
    _, fcu = pair
    client = FcuClient(f"udp://0.0.0.0:0@127.0.0.1:{fcu.link.offboard.port}", command_timeout_s=0.5)
    heard = []
    client.on("STATUSTEXT", heard.append)
    messages = [
        common.MAVLink_heartbeat_message(2, 12, 0, 0, 4, 3),
        common.MAVLink_statustext_message(6, b"I am not the flight controller"),
    ]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.bind(("127.0.0.2", 0))  # a stranger's address, which every machine has
        udp.settimeout(0.2)
        for message in messages:
            udp.sendto(Codec(1, 1).pack(message), ("127.0.0.1", client.port))
        assert client.wait(60.0)
        client.poll()
        assert not client.connected
        assert not heard
        client.send_heartbeat()
        with pytest.raises(socket.timeout):
            udp.recv(100)
    client.close()


def test_a_flight_controller_on_this_machine_is_heard_on_the_loopback_alone(pair):
    client, _ = pair
    assert client.local_address[0] == "127.0.0.1"


def test_an_autopilot_on_another_port_is_followed(pair):
    client, fcu = pair
    assert eventually(lambda: client.connected)
    fcu.stop()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.setblocking(False)
        heartbeat = common.MAVLink_heartbeat_message(2, 12, 0, 0, 4, 3)
        udp.sendto(Codec(1, 1).pack(heartbeat), ("127.0.0.1", client.port))

        def answered():
            client.send_heartbeat()
            with contextlib.suppress(BlockingIOError):
                return udp.recv(100)

        assert eventually(answered)


def test_handlers_get_their_messages(pair):
    client, _ = pair
    seen = []
    client.on("ATTITUDE", seen.append)
    assert eventually(lambda: len(seen) > 3)


def test_mode_names_are_mavros_own():
    assert custom_mode("OFFBOARD") == 0x00060000
    assert custom_mode("AUTO.LAND") == 0x06040000
    assert custom_mode("393216") == 0x00060000
    assert custom_mode("FLY") is None
    assert mode_name(0x03040000) == "AUTO.LOITER"
    assert mode_name(0x09990000) == f"CMODE({0x09990000})"
