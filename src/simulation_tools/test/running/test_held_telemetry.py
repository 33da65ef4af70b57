"""A link may keep its telemetry until the next scan: a client hears the same messages, in fewer datagrams."""

from __future__ import annotations

import socket
from itertools import chain

import pytest
from pymavlink.dialects.v20 import common as mavlink
from run_loop_rig import Rig

from simulation_tools.running.run_loop import HELD_US

SIMULATED_S = 0.5


def datagrams_of(holds):
    """What a client hears of a flight controller on the ground: one list of messages for each datagram."""
    rig = Rig(exact=True, real_time_factor=0.0)
    ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    ear.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
    ear.bind(("127.0.0.1", rig.port))
    ear.setblocking(False)
    if holds:
        rig.link.hold()
    rig.run_until(SIMULATED_S)
    rig.loop.set_paused(True)  # sends what is left
    parser, heard = mavlink.MAVLink(None), []
    while True:
        try:
            datagram = ear.recv(2048)
        except BlockingIOError:
            break
        heard.append([message.to_json() for message in parser.parse_buffer(datagram)])
    ear.close()
    rig.close()
    return heard


def test_a_client_hears_the_same_messages_in_the_same_order_in_fewer_datagrams():
    at_once, held = datagrams_of(holds=False), datagrams_of(holds=True)
    assert list(chain(*at_once)) == list(chain(*held))
    # 40 scans a second, and 100 instants with telemetry
    assert len(held) < 0.8 * len(at_once)


class Steps:
    """Notes, instant by instant, what the loop does."""

    def __init__(self):
        self.done = []

    def publish(self, output):
        self.done.append("scan" if output.scan is not None else "step")

    def report(self, *_):
        pass


@pytest.mark.table("has_lidar", [True, False])
def test_telemetry_goes_out_after_a_scan_or_a_little_later(has_lidar, monkeypatch):
    rig = Rig(exact=True, real_time_factor=0.0)
    steps = rig.loop._output = Steps()
    if not has_lidar:
        sense = rig.simulation.sense
        monkeypatch.setattr(rig.simulation, "sense", lambda: sense()._replace(scan=None))
    flush = rig.link.flush
    monkeypatch.setattr(rig.link, "flush", lambda: (steps.done.append("flush"), flush()))
    rig.run_until(0.3)
    rig.close()
    if has_lidar:
        scans = [index for index, what in enumerate(steps.done) if what == "scan"]
        assert scans
        assert all(steps.done[index + 1] == "flush" for index in scans)
    between = "".join({"scan": "s", "step": "s", "flush": "|"}[what] for what in steps.done).split("|")
    assert max(len(steps) for steps in between) <= HELD_US / 4000 + 1
