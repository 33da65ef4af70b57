"""The client against the flight controller's link over real UDP; the other side is stepped by a thread."""

from __future__ import annotations

import sys
import threading
import time
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "px4"))
from flight import NO_NOISE, Flight

from simulation_tools.mavlink import LinkError
from simulation_tools.mavros.client import FcuClient, custom_mode, mode_name, parse_fcu_url
from simulation_tools.px4.mavlink_link import MavlinkLink


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
        command_timeout_s=0.5,
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


def eventually(condition, timeout_s=5.0):
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
    assert eventually(lambda: not client.connected, 3.0)


def test_commands_are_answered_or_time_out(pair):
    client, fcu = pair
    assert eventually(lambda: fcu.flight.px4.home is not None)
    assert client.command(400, 1.0) == 0
    assert fcu.flight.px4.status.armed
    assert client.command(31000) == 3
    fcu.stop()
    began = time.monotonic()
    assert client.command(400, 0.0) is None
    assert time.monotonic() - began == pytest.approx(0.5, abs=0.2)


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


def test_fcu_urls_are_read_or_refused_in_a_sentence():
    assert parse_fcu_url("udp://:14540@127.0.0.1:14580") == ("0.0.0.0", 14540, "127.0.0.1", 14580)
    for bad in ("tcp://localhost:5760", "udp://:14540@", "udp://:99999@127.0.0.1:1", "", "udp://a:b@c:d"):
        with pytest.raises(LinkError, match="fcu_url"):
            parse_fcu_url(bad)
