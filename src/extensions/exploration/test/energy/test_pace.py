"""What a metre of a way takes, by flights whose times are worked out by hand."""

import numpy as np
import pytest

from exploration.energy import Course, EnergyWatch, Pace, WayBack
from exploration.next_view import ExplorationParameters
from exploration.planning import PathPlanner

SPEED_M_S = 0.5
SUPPOSED_S = 2.0
"""A metre, at that speed. The first 10 m of each course are taken to be flown so."""


def fly(pace, begin_m, end_m, speed_m_s, began_s=0.0):
    """Fly straight, with a look each second; return when it is over."""
    begin_m, end_m = np.array(begin_m, float), np.array(end_m, float)
    seconds = round(float(np.linalg.norm(end_m - begin_m)) / speed_m_s)
    for second in range(seconds + 1):
        pace.note(began_s + second, begin_m + (end_m - begin_m) * second / seconds, [end_m])
    pace.note(began_s + seconds, end_m, [])
    return began_s + seconds


def test_before_any_flight_a_way_takes_what_is_supposed():
    way_m = np.array([(0, 0, 0), (3, 4, 0), (3, 4, 5), (3, 4, 2)], float)
    assert Pace(SPEED_M_S).time_s(way_m) == pytest.approx(SUPPOSED_S * 13.0)


def test_a_slow_way_down_counts_for_what_leads_down_only():
    # Given 30 m straight down at 0.2 m/s, in 150 s, where 60 s are supposed
    pace = Pace(SPEED_M_S)
    fly(pace, (0, 0, 30), (0, 0, 0), 0.2)
    # Then 40 m take 20 + 150 s
    assert pace.of(Course.DOWN) == pytest.approx((20.0 + 150.0) / 40.0)
    assert pace.of(Course.UP) == pace.of(Course.LEVEL) == SUPPOSED_S
    # And a way of 4 m level, 2 m up and 10 m down takes as much
    way_m = np.array([(0, 0, 20), (4, 0, 20), (4, 0, 22), (4, 0, 12)], float)
    assert pace.time_s(way_m) == pytest.approx(6.0 * SUPPOSED_S + 10.0 * 4.25)


def test_a_fast_flight_is_no_reason_to_set_out_later():
    pace = Pace(SPEED_M_S)
    fly(pace, (0, 0, 0), (40, 0, 0), 1.0)
    assert pace.of(Course.LEVEL) == SUPPOSED_S


def test_a_stop_and_a_detour_on_the_way_count_but_a_hover_at_its_end_does_not():
    pace = Pace(SPEED_M_S)
    end_m = np.array((20.0, 0.0, 0.0))
    # Given 10 m in 20 s, 5 s of standing still, and a detour by which the way gets longer
    now_s = 0.0
    for x in np.arange(0.0, 10.1, 0.5):
        pace.note(now_s, np.array((x, 0.0, 0.0)), [end_m])
        now_s += 1.0
    for _ in range(5):
        pace.note(now_s, np.array((10.0, 0.0, 0.0)), [end_m])
        now_s += 1.0
    pace.note(now_s, np.array((10.0, 1.0, 0.0)), [np.array((10.0, 3.0, 0.0)), end_m])
    pace.note(now_s + 3.0, np.array((12.0, 0.0, 0.0)), [end_m])
    # Then 12 m took 29 s; a minute at the end takes no way
    assert pace.of(Course.LEVEL) == pytest.approx((20.0 + 29.0) / 22.0)
    for second in range(60):
        pace.note(now_s + 4.0 + second, end_m, [])
    assert pace.of(Course.LEVEL) == pytest.approx((20.0 + 29.0) / 22.0)


def test_a_uav_that_sinks_slowly_turns_home_earlier():
    # Given a battery that a second takes 1/600 of, and a home 20 m straight below
    p = ExplorationParameters(home_speed=SPEED_M_S)
    energy = EnergyWatch()
    back = WayBack(PathPlanner(), energy, p)
    back.begin(np.zeros(3))
    high_m = np.array((0.0, 0.0, 20.0))
    back.note(np.zeros(3))
    back.note(high_m)
    energy.offer(0.0, 1.0)
    back.decide(0.0, high_m)
    assert back.way is not None
    assert back.way.time_s == pytest.approx(40.0, abs=1.0)
    # When it has once flown down 20 m in 100 s, then its way home takes as long: (20 + 100) s for 30 m
    for second in range(101):
        back.note_pace(float(second), high_m * (1.0 - second / 100.0), [np.zeros(3)])
    assert back.way.time_s == pytest.approx(20.0 * 120.0 / 30.0, rel=0.03)
