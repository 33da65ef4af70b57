"""Lockstep waits for who works, by a clock that goes on only while it waits."""

from __future__ import annotations

import pytest

from simulation_tools.mavros.connection import Connection
from simulation_tools.running.lockstep import Barrier, Lockstep, working_topic
from simulation_tools.running.pacing import WallClock

TIMEOUT_S = 10.0


class Waits(Barrier):
    """A barrier whose clock goes on while it waits. events: what happens (functions) at which time."""

    def __init__(self, *participants):
        super().__init__(frozenset(participants))
        self.now_s, self.events = 0.0, []
        self.comes = True
        """Whether the setpoint is there at once."""

    def raise_for(self, stamp_ms):
        super().raise_for(stamp_ms)
        self.has_setpoint = self.comes

    def wait_for_participants(self, timeout_s):
        self.now_s += timeout_s
        for at_s, event in [each for each in self.events if each[0] <= self.now_s]:
            self.events.remove((at_s, event))
            event()
        return not self._silent()


class Link:
    """Counts what keeps the flight controller's connection alive."""

    def __init__(self):
        self.alive = 0

    def keep_alive(self):
        self.alive += 1

    def wait(self, timeout_s):
        self.barrier.wait_for_participants(timeout_s)
        return True

    def poll(self, time_us, until):
        """Nothing has come."""

    def take_orders(self, time_us):
        """Nobody orders anything."""


def waited(barrier, said=None):
    """Return whether lockstep got all answers to the scan of 100 ms, when it was over, and the link."""
    link, told = Link(), [] if said is None else said
    link.barrier = barrier
    clock = WallClock(now=lambda: barrier.now_s, sleep=lambda s: None)
    lockstep = Lockstep(barrier, link, clock, lambda: False, lambda: False, told.append)
    return lockstep.wait(100_000, TIMEOUT_S), barrier.now_s, link


def beats(barrier, name, until_s):
    barrier.events += [
        (0.5 * n, lambda n=n: barrier.beat(name, 0.5 * n)) for n in range(1, round(2 * until_s) + 1)
    ]


def test_a_participant_that_works_for_a_minute_is_waited_for_and_that_is_said_once():
    barrier, said = Waits("/explore/processed"), []
    beats(barrier, "/explore/processed", 60.0)
    barrier.events.append((61.0, lambda: barrier.acknowledge("/explore/processed", 100)))
    came, at_s, link = waited(barrier, said)
    assert came
    assert at_s == pytest.approx(61.0, abs=0.05)
    assert said == [
        "Lockstep waits for an acknowledgement on /explore/processed: it works, for more than 10 s."
    ]
    assert 58 <= link.alive <= 61  # once a second, so that MAVROS does not miss the flight controller


def test_one_whose_beats_have_stopped_for_the_time_out_is_a_miss():
    barrier = Waits("/explore/processed")
    beats(barrier, "/explore/processed", 20.0)
    came, at_s, _ = waited(barrier)
    assert not came
    assert at_s == pytest.approx(20.0 + TIMEOUT_S, abs=0.1)


def test_who_works_does_not_excuse_another_one_that_is_silent():
    barrier = Waits("/explore/processed", "/gridslam/processed")
    beats(barrier, "/explore/processed", 60.0)
    came, at_s, _ = waited(barrier)
    assert not came
    assert at_s == pytest.approx(TIMEOUT_S, abs=0.1)


@pytest.mark.table(("works_s", "comes_s", "is_miss"), [(30.0, 25.0, False), (30.0, None, True)])
def test_a_setpoint_is_waited_for_while_a_participant_works(works_s, comes_s, is_miss):
    barrier = Waits("/explore/processed")
    barrier.comes = False
    beats(barrier, "/explore/processed", works_s)
    if comes_s is not None:
        barrier.events.append((comes_s, lambda: barrier.on_setpoint(100)))
    barrier.events.append((works_s + 0.5, lambda: barrier.acknowledge("/explore/processed", 100)))
    came, at_s, _ = waited(barrier)
    assert came is not is_miss
    assert at_s == pytest.approx(works_s + (TIMEOUT_S if is_miss else 0.5), abs=0.1)


def test_without_beats_a_miss_comes_after_the_time_out_as_ever():
    came, at_s, _ = waited(Waits("/explore/processed"))
    assert (came, at_s) == (False, pytest.approx(TIMEOUT_S, abs=0.1))


def test_the_topic_of_the_beats_stands_beside_that_of_the_acknowledgements():
    assert working_topic("/explore/processed") == "/explore/working"


def test_any_message_keeps_mavros_connected_while_the_flight_controllers_time_stands_still():
    class Message:
        def __init__(self, kind):
            self.kind = kind

        def get_type(self):
            return self.kind

    now_s = [0.0]
    connection = Connection(TIMEOUT_S, lambda: now_s[0])
    connection.on_message(Message("HEARTBEAT"))
    for second in range(1, 40):
        now_s[0] = float(second)
        connection.on_message(Message("PING"))
        assert connection.alive
    now_s[0] += TIMEOUT_S
    assert not connection.alive
