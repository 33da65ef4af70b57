"""Which clouds are strays, which follow a clock that was set back, and which begin a recording again."""

from __future__ import annotations

import numpy as np
import pytest

from gridslam.volume import Pose
from gridslam.volume.clock_back import ClockBack, Follows, Placed

PERIOD_S, SPEED_M_S = 0.1, 2.0


def placed(x_m, correction_m=0.0):
    return Placed(Pose.level(x_m, 0.0, 0.0), Pose.level(correction_m, 0.0, 0.0))


def flown(seconds=20.0):
    """Return what has judged a flight along x from 0, its last stamp and the last x."""
    clock = ClockBack()
    stamps_s = 1000.0 + np.arange(0.0, seconds, PERIOD_S)
    places_m = SPEED_M_S * (stamps_s - 1000.0)
    assert {clock.classify(*each) for each in zip(stamps_s, map(placed, places_m))} == {Follows.TAKE}
    return clock, stamps_s[-1], places_m[-1]


def judged(clock, stamp_s, x_m, count=20, correction_m=0.0):
    """Judge clouds that go on from a stamp and a place."""
    return [
        clock.classify(stamp_s + PERIOD_S * k, placed(x_m + SPEED_M_S * PERIOD_S * k, correction_m))
        for k in range(count)
    ]


@pytest.mark.table("back_s", [0.05, 0.4, 1.0])
def test_a_clock_that_is_trimmed_loses_only_the_clouds_until_it_has_caught_up(back_s):
    clock, stamp_s, x_m = flown()
    follow = judged(clock, stamp_s - back_s, x_m)
    assert set(follow) == {Follows.LEAVE_OUT, Follows.TAKE}
    assert follow.count(Follows.LEAVE_OUT) <= back_s / PERIOD_S + 1


def test_a_stray_is_left_out():
    clock, stamp_s, x_m = flown()
    assert clock.classify(stamp_s - 50.0, placed(x_m)) is Follows.LEAVE_OUT
    assert clock.classify(stamp_s - 0.05, placed(x_m)) is Follows.LEAVE_OUT
    assert set(judged(clock, stamp_s + PERIOD_S, x_m)) == {Follows.TAKE}


@pytest.mark.table("back_s", [1.5, 5.0, 600.0, 31_536_000.0])
def test_behind_a_clock_that_was_set_back_the_map_goes_on(back_s):
    clock, stamp_s, x_m = flown()
    follow = judged(clock, stamp_s - back_s, x_m)
    assert follow[2] is Follows.NEXT_FLIGHT
    assert Follows.BEGIN_ANEW not in follow
    assert set(follow[3:]) == {Follows.TAKE}


@pytest.mark.table(("seconds", "back_s"), [(2.0, 1.2), (5.0, 1.5), (5.0, 4.0), (20.0, 12.0)])
def test_a_clock_that_is_set_back_soon_after_take_off_leaves_the_map(seconds, back_s):
    # given a UAV that hovers where its map began
    clock = ClockBack()
    for stamp_s in 1000.0 + np.arange(0.0, seconds, PERIOD_S):
        clock.classify(stamp_s, placed(0.0))
    follow = [clock.classify(stamp_s - back_s + PERIOD_S * k, placed(0.0)) for k in range(1, 20)]
    assert Follows.BEGIN_ANEW not in follow
    assert follow[-1] is Follows.TAKE


@pytest.mark.table("back_s", [19.9, 1000.0])
def test_a_recording_that_begins_again_begins_the_map_anew(back_s):
    clock, stamp_s, _ = flown()
    follow = judged(clock, stamp_s - back_s, 0.0)
    assert follow[2] is Follows.BEGIN_ANEW
    assert Follows.NEXT_FLIGHT not in follow


def test_a_recording_of_a_sensor_at_rest_begins_the_map_anew():
    clock = ClockBack()
    for stamp_s in np.arange(0.0, 20.0, PERIOD_S):
        clock.classify(stamp_s, placed(0.0))
    assert [clock.classify(stamp_s, placed(0.0)) for stamp_s in (0.0, 0.1, 0.2)][-1] is Follows.BEGIN_ANEW


def test_where_slam_begins_anew_so_does_the_map():
    clock, stamp_s, x_m = flown()
    assert judged(clock, stamp_s - 5.0, x_m, correction_m=0.5)[2] is Follows.BEGIN_ANEW


def test_a_first_cloud_that_comes_again_is_left_out():
    clock = ClockBack()
    told = [clock.classify(0.0, placed(0.0)) for _ in range(10)]
    assert told == [Follows.TAKE] + 9 * [Follows.LEAVE_OUT]
