"""Which scan is acknowledged when, and which pose is followed when."""

import pytest
from errand_model import pose

from flight_basics.errand.barriers import MAP_LATE_S, STARVED_S, MapBarrier, SteeringBarrier
from flight_basics.errand.messages import Heard, Scan, Steered


class Clock:
    now_s = 0.0

    def __call__(self):
        return self.now_s


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def barrier(clock):
    barrier = MapBarrier(clock)
    barrier.take(Scan(10.0, "scan"), True)
    return barrier


def test_a_scan_waits_for_pose_and_map_while_something_is_flown(barrier):
    assert barrier.passed(is_active=True, is_busy=False) is None
    barrier.take(pose(10.0), True)
    assert barrier.passed(is_active=True, is_busy=False) is None
    barrier.note_map(10.0 - MAP_LATE_S)
    assert barrier.passed(is_active=True, is_busy=True) is None
    assert barrier.passed(is_active=True, is_busy=False) == "scan"
    assert barrier.passed(is_active=True, is_busy=False) is None  # once


def test_nobody_waits_for_a_map_that_does_not_come(barrier, clock):
    barrier.take(pose(10.0), True)
    clock.now_s = STARVED_S
    assert barrier.passed(is_active=True, is_busy=False) == "scan"


def test_while_nothing_is_flown_a_scan_waits_for_nothing(barrier):
    assert barrier.waits
    assert barrier.passed(is_active=False, is_busy=False) == "scan"
    assert not barrier.waits


@pytest.mark.table("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0), (1, 0, 2), (0, 2, 1), (2, 0, 1)])
def test_a_mission_follows_the_pose_of_a_scan_that_is_steered_by_in_whichever_order(order):
    here, barrier = pose(1.0), SteeringBarrier()
    messages = Scan(1.0, "scan"), here, Steered(1.0)
    told = [barrier.take(messages[i], True) for i in order]
    assert told == [None, None, here]
    # When it leads to no new setpoint, then the scan is acknowledged at once, and the pose is followed once
    barrier.note_followed(False)
    assert barrier.passed(True, False) == "scan"
    assert barrier.take(Steered(1.0), True) is None
    # When it leads to one, then after that was heard
    assert [barrier.take(each, True) for each in (Scan(2.0, "next"), pose(2.0))] == [None, None]
    assert barrier.take(Steered(2.0), True) is not None
    barrier.note_followed(True)
    assert barrier.passed(True, False) is None
    barrier.take(Heard(), True)
    assert barrier.passed(True, False) == "next"
