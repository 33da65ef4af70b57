"""A pilot's hands: keys and sticks become velocities, and released ones become hover."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flight_basics.errors import ParameterError
from inspection_tools.teleop import FASTEST_M_S, HOVER, JoystickPilot, KeyboardPilot, TeleopParameters


@pytest.mark.table(
    ("key", "velocity"),
    [
        ("i", (2.0, 0.0, 0.0)),
        (",", (-2.0, 0.0, 0.0)),
        ("j", (0.0, 2.0, 0.0)),
        ("l", (0.0, -2.0, 0.0)),
        ("u", (math.sqrt(2.0), math.sqrt(2.0), 0.0)),
        (".", (-math.sqrt(2.0), -math.sqrt(2.0), 0.0)),
        ("t", (0.0, 0.0, 0.5)),
        ("k", HOVER),
    ],
)
def test_a_key_is_a_direction_at_the_speed_asked_for(key, velocity):
    pilot = KeyboardPilot(TeleopParameters(speed=2.0))
    assert pilot.press(key, 10.0)
    assert pilot.velocity(10.3) == pytest.approx(velocity)


def test_a_key_that_is_released_becomes_hover_after_the_hold_time():
    pilot = KeyboardPilot(TeleopParameters(hold_time=0.6))
    pilot.press("i", 10.0)
    assert pilot.velocity(10.59) != HOVER
    assert pilot.velocity(10.61) == HOVER


def test_before_any_key_the_uav_hovers():
    assert KeyboardPilot().velocity(0.0) == HOVER


def test_a_key_without_a_meaning_stops_the_uav():
    pilot = KeyboardPilot()
    pilot.press("i", 10.0)
    assert not pilot.press("x", 10.1)
    assert pilot.velocity(10.1) == HOVER


def test_faster_and_slower_undo_each_other_and_keep_the_direction():
    pilot = KeyboardPilot(TeleopParameters(speed=1.0))
    pilot.press("i", 0.0)
    pilot.press("q", 0.1)
    assert pilot.velocity(0.1) == pytest.approx((1.1, 0.0, 0.0))
    pilot.press("z", 0.1)
    assert pilot.velocity(0.1) == pytest.approx((1.0, 0.0, 0.0))


@given(st.text(alphabet="uiojklm,.tbqz", max_size=200))
def test_no_sequence_of_keys_is_faster_than_the_limit(keys):
    pilot = KeyboardPilot()
    for key in keys:
        pilot.press(key, 0.0)
        assert math.hypot(*pilot.velocity(0.0)) <= FASTEST_M_S + 1e-9


@given(st.lists(st.floats(allow_nan=True), min_size=5, max_size=8))
def test_sticks_in_any_position_stay_within_the_speed(axes):
    pilot = JoystickPilot(TeleopParameters(speed=2.0, climb_speed=0.5))
    pilot.move(axes, 0.0)
    ahead, left, up = pilot.velocity(0.0)
    assert math.hypot(ahead, left) <= 2.0 + 1e-9
    assert abs(up) <= 0.5


def test_sticks_count_from_the_edge_of_the_dead_zone():
    pilot = JoystickPilot(TeleopParameters(speed=1.0, dead_zone=0.2))
    pilot.move([0.2, 0.6, 0.0, 0.0, -1.0], 0.0)
    assert pilot.velocity(0.0) == pytest.approx((0.5, 0.0, -0.5))


def test_a_silent_joystick_becomes_hover():
    pilot = JoystickPilot(TeleopParameters(hold_time=0.5))
    pilot.move([0.0, 1.0, 0.0, 0.0, 0.0], 1.0)
    assert pilot.velocity(1.4) != HOVER
    assert pilot.velocity(1.6) == HOVER


def test_a_joystick_with_too_few_axes_is_one_sentence_and_hover():
    pilot = JoystickPilot()
    pilot.move([0.0, 1.0, 0.0, 0.0, 0.0], 1.0)
    with pytest.raises(ParameterError, match="has 2 axes, but axis 4"):
        pilot.move([0.0, 1.0], 1.1)
    assert pilot.velocity(1.1) == HOVER
