"""How near a UAV whose algorithm does not climb comes to floor and ceiling."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cepa import CepaParameters
from cepa.motion import Ranging
from cepa.steering.height_guard import guarded_climb, stopping_speed

P = CepaParameters(body_radius=0.2, r_lb=0.25, r_ub=0.5)
UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)


def ranging(range_m, direction=DOWN):
    """Of a range finder 0.05 m from the body's middle."""
    return Ranging((0.0, 0.0, 0.05 * direction[2]), direction, range_m, 0.05, 40.0)


def guarded(climb_m_s, *rangings):
    told = []
    return guarded_climb(climb_m_s, rangings, P, told.append), told


@given(free_m=st.floats(0.001, 30.0))
def test_the_speed_is_what_is_lost_on_the_free_way(free_m):
    speed = stopping_speed(free_m, P)
    late_s = P.braking_latency + 2.0 * 0.35  # lag of the vertical velocity: cepa/doc/three_dimensions.md
    assert speed * late_s + speed**2 / (2.0 * P.braking_deceleration) == pytest.approx(free_m)


@pytest.mark.table(("wanted", "direction"), [(-1.0, DOWN), (1.0, UP)])
def test_the_uav_stops_at_r_lb(wanted, direction):
    """A UAV that follows with the lag of the argument, told of its range twenty times a second."""
    distance_m, speed, step_s = 2.0, 0.0, 0.05
    for _ in range(400):
        climb, told = guarded(wanted, ranging(distance_m - 0.05, direction))
        speed += (abs(climb) - speed) * step_s / 0.35
        distance_m -= speed * step_s
        assert distance_m > P.r_lb - 0.01
        assert not told
    assert distance_m == pytest.approx(P.r_lb, abs=0.01)


@pytest.mark.table("climb", [0.0, 0.7, -0.7])
def test_what_is_far_or_the_other_way_does_not_matter(climb):
    assert guarded(climb) == (climb, [])
    assert guarded(climb, ranging(5.0), ranging(math.inf, UP)) == (climb, [])
    near = ranging(0.1, UP if climb < 0.0 else DOWN)
    assert guarded(climb, near) == (climb, [])


@pytest.mark.table("range_m", [0.1, 0.2, -math.inf])
def test_within_r_lb_it_sinks_no_more_and_is_not_pushed_up(range_m):
    assert guarded(-0.5, ranging(range_m)) == (0.0, [])
    assert guarded(0.0, ranging(range_m)) == (0.0, [])
    assert guarded(0.5, ranging(range_m)) == (0.5, [])


def test_a_range_finder_that_measures_nothing_is_told_of():
    climb, told = guarded(-0.5, ranging(math.nan))
    assert climb == 0.0
    assert told == ["The range finder that looks down measures nothing (NaN); the UAV does not sink."]
    assert guarded(0.5, ranging(math.nan)) == (0.5, [])
