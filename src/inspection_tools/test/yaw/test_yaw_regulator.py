"""The yaw regulator against closed form, its hystereses, and the tie at the exact rear."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flight_basics.errors import VelocityError
from inspection_tools import YawRegulator, YawRegulatorParameters

STEP_S = 0.025  # a lidar at 40 Hz


def in_body(speed, direction_rad, yaw_rad):
    return (speed * math.cos(direction_rad - yaw_rad), speed * math.sin(direction_rad - yaw_rad))


def turn(regulator, yaw_rad, direction_rad, seconds, speed=1.0, step_s=STEP_S):
    """Yaw of a UAV that travels along a fixed direction and follows the yaw rate at once."""
    yaws = [yaw_rad]
    for _ in range(round(seconds / step_s)):
        yaws.append(yaws[-1] + step_s * regulator.update(in_body(speed, direction_rad, yaws[-1])))
    return np.array(yaws)


def test_turns_at_the_limit_and_then_exponentially():
    """From 2 rad with gain 1.5 and limit 1: 1 rad/s until 2/3 rad is left, then that times (1 - 1.5 dt)^n."""
    p = YawRegulatorParameters(gain=1.5, max_yaw_rate=1.0)
    yaws = turn(YawRegulator(p), -2.0, 0.0, seconds=6.0)
    expected = -2.0
    for yaw in yaws:
        assert yaw == pytest.approx(expected, abs=1e-9)
        expected += STEP_S * min(1.0, 1.5 * -expected)
    saturated_steps = math.ceil((2.0 - 1.0 / 1.5) / STEP_S)
    assert yaws[saturated_steps] == pytest.approx(-2.0 + saturated_steps * STEP_S)
    left = -yaws[saturated_steps]
    assert yaws[-1] == pytest.approx(-left * (1.0 - 1.5 * STEP_S) ** (240 - saturated_steps), rel=1e-9)


@given(
    yaw=st.floats(-math.pi, math.pi),
    direction=st.floats(-math.pi, math.pi),
    gain=st.floats(0.5, 5.0),
    limit=st.floats(0.3, 3.0),
    step_s=st.sampled_from([0.01, 0.025, 0.1]),
)
def test_converges_from_everywhere_without_turning_back(yaw, direction, gain, limit, step_s):
    p = YawRegulatorParameters(gain=gain, max_yaw_rate=limit)
    seconds = math.pi / limit + 12.0 / gain  # the whole turn at the limit, then twelve time constants
    yaws = turn(YawRegulator(p), yaw, direction, seconds, step_s=step_s)
    off = (yaws[-1] - direction + math.pi) % (2.0 * math.pi) - math.pi
    assert abs(off) < 1e-3
    steps = np.diff(yaws)
    assert (steps >= 0.0).all() or (steps <= 0.0).all()
    assert np.abs(steps).max() <= limit * step_s + 1e-12
    assert abs(yaws[-1] - yaws[0]) <= math.pi + 1e-9  # the short way round


@pytest.mark.table("y", [0.0, -0.0])
def test_the_exact_rear_goes_left(y):
    assert YawRegulator().update((-1.0, y)) == YawRegulatorParameters().max_yaw_rate


def test_noise_about_the_rear_does_not_make_it_turn_to_and_fro():
    """A direction of 180 +- 6 degrees (1 sigma), as an emergency's: the sense of turn is chosen once."""
    for seed in range(20):
        rng = np.random.default_rng(seed)
        regulator, yaw, rates = YawRegulator(), 0.0, []
        for _ in range(400):
            rates.append(regulator.update(in_body(1.0, math.pi + 0.1 * rng.standard_normal(), yaw)))
            yaw += STEP_S * rates[-1]
        senses = np.sign(rates[:60])  # the first 1.5 s: 1 rad/s, still far from the goal
        assert abs(senses.sum()) == 60, f"seed {seed}"
        assert abs(abs(yaw) - math.pi) < 0.1


def test_a_real_change_of_direction_beyond_the_margin_changes_the_sense():
    regulator = YawRegulator(YawRegulatorParameters(turn_margin=0.5))
    assert regulator.update(in_body(1.0, 3.0, 0.0)) > 0.0
    assert regulator.update(in_body(1.0, -3.0, 0.0)) > 0.0  # 0.14 rad past the rear: keeps on
    assert regulator.update(in_body(1.0, -2.5, 0.0)) < 0.0  # 0.64 rad past it: the other way is shorter


def test_switches_off_when_hovering_with_hysteresis():
    regulator = YawRegulator(YawRegulatorParameters(speed_on=0.25, speed_off=0.15))
    speeds = [0.1, 0.2, 0.24, 0.26, 0.2, 0.16, 0.14, 0.2, 0.24, 0.3]
    turning = [regulator.update((0.0, speed)) != 0.0 for speed in speeds]
    assert turning == [False, False, False, True, True, True, False, False, False, True]


def test_the_sense_of_turn_is_not_kept_through_a_hover():
    regulator = YawRegulator()
    assert regulator.update(in_body(1.0, 3.0, 0.0)) > 0.0
    assert regulator.update((0.0, 0.0)) == 0.0
    assert regulator.update(in_body(1.0, -3.0, 0.0)) < 0.0  # the shorter way


def test_looks_where_it_wants_to_go_when_held_back():
    p = YawRegulatorParameters(gain=1.0, max_yaw_rate=2.0, speed_on=0.25, speed_off=0.15)
    regulator = YawRegulator(p)
    assert regulator.update((0.0, 0.0), (0.0, -1.0)) == pytest.approx(-math.pi / 2)
    assert regulator.update((0.0, 0.0), (0.0, -0.2)) == pytest.approx(-math.pi / 2)  # its own hysteresis
    assert regulator.update((0.0, 0.0), (0.0, -0.1)) == 0.0
    # what is flown goes before what was wanted
    assert regulator.update((0.0, 1.0), (0.0, -1.0)) == pytest.approx(math.pi / 2)


def test_reset_forgets_the_hystereses():
    regulator = YawRegulator()
    regulator.update((-1.0, -0.1))
    regulator.reset()
    assert regulator.update((0.0, 0.2)) == 0.0
    assert regulator.update((-1.0, 0.0)) > 0.0


@pytest.mark.table("bad", [math.nan, math.inf])
def test_bad_numbers_are_refused_and_change_nothing(bad):
    regulator = YawRegulator()
    regulator.update((0.0, 1.0))
    for velocities in (((bad, 0.0),), ((0.0, 0.0), (0.0, bad))):
        with pytest.raises(VelocityError, match="not finite"):
            regulator.update(*velocities)
    assert regulator.update((0.0, 0.2)) > 0.0  # still on


def test_a_front_that_is_given_is_turned_to_with_a_gain_of_its_own():
    regulator = YawRegulator(YawRegulatorParameters(gain=1.0, front_gain=3.0, max_yaw_rate=5.0))
    direction = (math.cos(0.2), math.sin(0.2))
    assert regulator.turn_to(direction) == pytest.approx(3.0 * 0.2)
    assert regulator.update(direction) == pytest.approx(0.2)
