"""Jerk-limited motion: limits held, ends exactly, closed forms."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.px4.control.trajectory import SmoothAxis, speed_that_stops_within

speeds = st.floats(-6.0, 6.0)


@given(speeds, speeds, st.floats(-5.0, 5.0), st.floats(1.0, 5.0), st.floats(0.5, 10.0))
def test_any_state_reaches_any_velocity_within_the_limits(start, wanted, acceleration, limit, jerk):
    axis = SmoothAxis()
    axis.start(0.0, start, acceleration)
    _, *times = axis.durations(wanted, limit, jerk)
    total = sum(times)
    assert min(times) >= 0.0
    position, velocity, a, t = 0.0, start, acceleration, 0.0
    while t < total + 0.02:
        axis.advance(wanted, limit, jerk, 0.008)
        t += 0.008
        assert abs(axis.acceleration - a) <= jerk * 0.008 + 1e-9
        assert abs(axis.acceleration) <= max(limit, abs(acceleration)) + 1e-9
        # The mean velocity of a step lies near its ends'.
        assert abs(axis.position - position - 0.008 * 0.5 * (velocity + axis.velocity)) < 1e-4
        position, velocity, a = axis.position, axis.velocity, axis.acceleration
    assert velocity == pytest.approx(wanted, abs=1e-6)
    assert a == pytest.approx(0.0, abs=1e-6)


def test_from_rest_the_times_are_the_closed_form():
    axis = SmoothAxis()
    # 5 m/s at 3 m/s2 and 4 m/s3: 0.75 s up, 5/3 - 0.75 s constant, 0.75 s down.
    assert axis.durations(5.0, 3.0, 4.0) == pytest.approx((4.0, 0.75, 5.0 / 3.0 - 0.75, 0.75))
    # 1 m/s does not reach 3 m/s2: the peak is sqrt(4 * 1).
    assert axis.durations(-1.0, 3.0, 4.0) == pytest.approx((-4.0, 0.5, 0.0, 0.5))


@given(st.floats(0.01, 200.0), st.floats(1.0, 5.0), st.floats(1.0, 10.0))
def test_a_point_that_follows_the_speed_stops_in_time(distance, acceleration, jerk):
    speed = speed_that_stops_within(distance, acceleration, jerk)
    # v / (2 a) v of braking, and the time a / j that the acceleration takes to build up, twice.
    assert speed * speed / (2.0 * acceleration) + 2.0 * speed * acceleration / jerk == pytest.approx(distance)
    assert speed_that_stops_within(-1.0, acceleration, jerk) == 0.0
    axis = SmoothAxis()
    axis.start(0.0, speed)
    for _ in range(20_000):
        axis.advance(0.0, acceleration, jerk, 0.01)
        if axis.velocity == 0.0:
            break
    assert axis.position <= distance


def test_an_axis_at_rest_stays():
    axis = SmoothAxis()
    axis.start(3.0)
    axis.advance(0.0, 3.0, 4.0, 0.1)
    assert (axis.position, axis.velocity, axis.acceleration) == (3.0, 0.0, 0.0)
    assert not math.isnan(axis.position)
