"""When the flight controller counts as gone: by its own clock, and by the wall clock when it says nothing."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import common

from simulation_tools.mavros.connection import Connection

HEARTBEAT = common.MAVLink_heartbeat_message(2, 12, 0, 0, 4, 3)


class Pair:
    """A flight controller that simulates `factor` seconds in a second, and the connection to it."""

    def __init__(self, factor, time_boot_ms=0):
        self.factor = factor
        self.wall_s = 0.0
        self.boot_ms = time_boot_ms
        self.connection = Connection(10.0, lambda: self.wall_s)

    def run(self, simulated_s, heartbeats=True):
        """Send an attitude each 0.1 s and a heartbeat each second; return whether it was alive throughout."""
        alive = True
        for number in range(round(10.0 * simulated_s)):
            if heartbeats and number % 10 == 0:
                self.connection.on_message(HEARTBEAT)
            self.connection.on_message(common.MAVLink_attitude_message(self.boot_ms, *(0.0,) * 6))
            self.boot_ms += 100
            self.wall_s += 0.1 / self.factor
            alive = alive and self.connection.alive
        return alive


def test_nothing_heard_is_no_connection_and_without_heartbeats_neither():
    pair = Pair(1.0)
    assert not pair.connection.alive
    pair.run(5.0, heartbeats=False)
    assert not pair.connection.alive


@pytest.mark.table("factor", [0.08, 1.0, 50.0])
def test_heartbeats_of_a_simulation_at_any_speed_keep_it(factor):
    """At 0.08 they come every 12.5 s of wall time."""
    assert Pair(factor).run(60.0)


@pytest.mark.table("factor", [0.08, 1.0, 50.0])
def test_without_heartbeats_it_ends_after_10_s_of_the_vehicles_time(factor):
    pair = Pair(factor)
    pair.run(5.0)  # the last heartbeat at 4 s
    assert pair.run(8.8, heartbeats=False)
    assert not pair.run(0.4, heartbeats=False)
    assert pair.run(0.1)  # the next heartbeat brings it back


def test_silence_ends_it_after_ten_seconds_of_wall_time():
    pair = Pair(1.0)
    pair.run(5.0)
    pair.wall_s += 9.8
    assert pair.connection.alive
    pair.wall_s += 0.2
    assert not pair.connection.alive


def test_a_flight_controller_that_starts_again_is_followed():
    pair = Pair(1.0, time_boot_ms=600_000)
    pair.run(5.0)
    pair.boot_ms = 0
    assert pair.run(5.0, heartbeats=False)
    assert not pair.run(6.0, heartbeats=False)


def test_a_late_message_does_not_set_the_clock_back():
    pair = Pair(1.0)
    pair.run(5.0)
    for _ in range(20):
        pair.run(0.5, heartbeats=False)
        pair.connection.on_message(common.MAVLink_attitude_message(pair.boot_ms - 900, *(0.0,) * 6))
    assert not pair.connection.alive
