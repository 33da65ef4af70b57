"""The position controller's approach against closed form, and its rules on bad poses and clocks."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flight_basics.bounds import MAX_TIME_STEP_S
from flight_basics.errors import PoseError
from inspection_tools import PositionController, PositionControllerParameters
from inspection_tools.position_controller import approach_speed

STEP_S = 0.01  # odometry at 100 Hz


def fly(controller, goal, start=(0.0, 0.0, 0.0), yaw=0.0, seconds=60.0, step_s=STEP_S):
    """Fly a UAV that follows its commands at once; returns (position, velocity) of each step."""
    controller.set_setpoint(goal)
    position, flight = list(start), []
    for index in range(int(seconds / step_s)):
        x, y, z = controller.update(index * step_s, position, yaw).velocity_m_s
        cos, sin = math.cos(yaw), math.sin(yaw)
        velocity = (cos * x - sin * y, sin * x + cos * y, z)
        flight.append((tuple(position), velocity))
        position = [p + v * step_s for p, v in zip(position, velocity)]
    return flight


def test_speed_rises_cruises_and_brakes_as_closed_form_says():
    """40 m at 2 m/s: ramp v = a t, cruise, then v^2 = 2 b (d - b / (2 g^2)), at last v = g d."""
    p = PositionControllerParameters(max_speed=2.0, max_acceleration=1.0, braking_deceleration=0.8, gain=1.0)
    flight = fly(PositionController(p), (40.0, 0.0, 0.0))
    for index in range(200):  # 2 s of acceleration
        assert flight[index][1][0] == pytest.approx(index * STEP_S * 1.0, abs=1e-9)
    joint_m = 0.8 / 1.0**2
    braking_m = 2.0**2 / (2 * 0.8) + 0.8 / 2.0  # 2.9 m
    for (x, _, _), (v, _, _) in flight[200:]:
        left_m = 40.0 - x
        if left_m > braking_m:
            assert v == pytest.approx(2.0)
        elif left_m > joint_m:
            assert v**2 == pytest.approx(2 * 0.8 * (left_m - joint_m / 2), rel=1e-9)
        else:
            assert v == pytest.approx(left_m, abs=1e-9)
    # time: ramp 2 s (2 m), cruise, braking from 2.0 to 0.8 m/s in 1.5 s, then e-folding once a second
    expected_s = 2.0 + (40.0 - 2.0 - braking_m) / 2.0 + (2.0 - 0.8) / 0.8 + math.log(joint_m / 0.01)
    reached_s = next(i for i, ((x, _, _), _) in enumerate(flight) if 40.0 - x < 0.01) * STEP_S
    assert reached_s == pytest.approx(expected_s, abs=0.05)


@given(
    distance=st.floats(0.01, 30.0),
    bearing=st.floats(-math.pi, math.pi),
    climb=st.floats(-5.0, 5.0),
    max_speed=st.floats(0.1, 8.0),
    acceleration=st.floats(0.2, 6.0),
    braking_share=st.floats(0.1, 1.0),
    gain=st.floats(0.2, 3.0),
    yaw=st.floats(-math.pi, math.pi),
)
def test_never_overshoots_nor_exceeds_its_limits(
    distance, bearing, climb, max_speed, acceleration, braking_share, gain, yaw
):
    p = PositionControllerParameters(
        max_speed=max_speed,
        max_acceleration=acceleration,
        braking_deceleration=max(braking_share * acceleration, 0.1),
        gain=gain,
    )
    goal = (distance * math.cos(bearing), distance * math.sin(bearing), climb)
    flight = fly(PositionController(p), goal, yaw=yaw, seconds=30.0)
    last = (0.0, 0.0, 0.0)
    for position, velocity in flight:
        along = position[0] * math.cos(bearing) + position[1] * math.sin(bearing)
        across = position[1] * math.cos(bearing) - position[0] * math.sin(bearing)
        assert along <= distance + 1e-9
        assert abs(across) < 1e-9  # straight
        assert abs(position[2]) <= abs(climb) + 1e-9
        assert math.hypot(velocity[0], velocity[1]) <= max_speed + 1e-9
        assert abs(velocity[2]) <= p.max_vertical_speed + 1e-9
        change = math.hypot(velocity[0] - last[0], velocity[1] - last[1])
        assert change <= acceleration * STEP_S + 1e-9
        assert abs(velocity[2] - last[2]) <= p.max_vertical_acceleration * STEP_S + 1e-9
        last = velocity


def test_height_is_approached_as_closed_form_says():
    """Down at 1 m/s; at half of 1 m/s^2 from 1^2 / (2 * 0.5) + 0.5 / 2 = 1.25 m on; v = d within 0.5 m."""
    flight = fly(PositionController(), (0.0, 0.0, -10.0), seconds=30.0)
    for (_, _, z), (_, _, v) in flight[100:]:
        left_m = 10.0 + z
        if left_m > 1.25:
            assert v == pytest.approx(-1.0)
        elif left_m > 0.5:
            assert v**2 == pytest.approx(left_m - 0.25, rel=1e-9)
        else:
            assert v == pytest.approx(-left_m, abs=1e-9)
    assert flight[-1][0][2] == pytest.approx(-10.0, abs=1e-3)


@pytest.mark.table("lag_s", [0.1, 0.15, 0.2])
def test_does_not_overshoot_with_a_flight_controller_that_lags(lag_s):
    """Velocity loop of first order: with gain x lag <= 1/4 the last part is at least critically damped."""
    controller = PositionController()
    assert controller.parameters.gain * lag_s <= 0.25
    controller.set_setpoint((40.0, 0.0, 0.0))
    x = velocity = 0.0
    for index in range(6000):
        command = controller.update(index * STEP_S, (x, 0.0, 0.0), 0.0)
        velocity += (command.velocity_m_s[0] - velocity) * STEP_S / lag_s
        x += velocity * STEP_S
        assert x <= 40.0
    assert x == pytest.approx(40.0, abs=1e-3)


@given(
    distance=st.floats(0.0, 100.0),
    limit=st.floats(0.0, 10.0),
    deceleration=st.floats(0.1, 10.0),
    gain=st.floats(0.1, 5.0),
)
def test_approach_speed_has_no_kink_and_no_harder_braking(distance, limit, deceleration, gain):
    """Deceleration of following v(d) is v dv/dd: at most the parameter everywhere."""
    h = 1e-4
    v0 = approach_speed(distance, limit, deceleration, gain)
    v1 = approach_speed(distance + h, limit, deceleration, gain)
    assert 0.0 <= v0 <= v1 <= limit
    assert (v1 - v0) / h * v0 <= deceleration * (1.0 + 1e-3)


@pytest.mark.table(
    ("yaw", "expected"),
    [(0.0, (1.0, 0.0)), (math.pi / 2, (0.0, -1.0)), (math.pi, (-1.0, 0.0)), (-math.pi / 2, (0.0, 1.0))],
)
def test_the_command_is_in_the_levelled_body_frame(yaw, expected):
    """A goal straight along x: a UAV that faces left (yaw 90 degrees) must go to its right."""
    controller = PositionController(PositionControllerParameters(max_speed=1.0))
    controller.set_setpoint((100.0, 0.0, 0.0))
    for index in range(200):
        command = controller.update(index * STEP_S, (0.0, 0.0, 0.0), yaw)
    assert command.velocity_m_s == pytest.approx((*expected, 0.0), abs=1e-12)


def test_hovers_without_a_setpoint():
    command = PositionController().update(3.0, (1.0, 2.0, 3.0), 0.5)
    assert command.velocity_m_s == (0.0, 0.0, 0.0)
    assert command.goal_reached is False


def test_goal_reached_has_hysteresis_and_starts_anew_with_a_new_goal():
    p = PositionControllerParameters(goal_tolerance=0.2, goal_hysteresis=0.1)
    controller = PositionController(p)
    controller.set_setpoint((0.0, 0.0, 0.0))
    distances = [0.5, 0.25, 0.19, 0.25, 0.29, 0.31, 0.25, 0.2]
    reached = [
        controller.update(i * STEP_S, (0.0, 0.0, d), 0.0).goal_reached for i, d in enumerate(distances)
    ]
    assert reached == [False, False, True, True, True, False, False, True]
    controller.set_setpoint((0.0, 0.0, 0.0))  # the same again: still there
    assert controller.update(1.0, (0.0, 0.0, 0.25), 0.0).goal_reached
    controller.set_setpoint((0.0, 0.0, 0.01))
    assert not controller.update(1.1, (0.0, 0.0, 0.25), 0.0).goal_reached


def test_a_gap_between_poses_does_not_let_the_velocity_jump():
    controller = PositionController()
    controller.set_setpoint((40.0, 0.0, 0.0))
    controller.update(0.0, (0.0, 0.0, 0.0), 0.0)
    command = controller.update(5.0, (0.0, 0.0, 0.0), 0.0)
    assert command.velocity_m_s[0] == pytest.approx(2.0 * MAX_TIME_STEP_S)


def test_a_clock_that_jumps_back_starts_from_rest_and_keeps_the_setpoint():
    controller = PositionController()
    controller.set_setpoint((40.0, 0.0, 0.0))
    for index in range(100):
        cruising = controller.update(10.0 + index * STEP_S, (0.0, 0.0, 0.0), 0.0)
    assert cruising.velocity_m_s[0] > 1.5
    command = controller.update(2.0, (0.0, 0.0, 0.0), 0.0)
    assert command.velocity_m_s == (0.0, 0.0, 0.0)
    assert controller.update(2.01, (0.0, 0.0, 0.0), 0.0).velocity_m_s[0] == pytest.approx(0.02)


@pytest.mark.table("bad", [math.nan, math.inf])
def test_bad_numbers_are_refused_and_change_nothing(bad):
    controller = PositionController()
    controller.set_setpoint((40.0, 0.0, 0.0))
    controller.update(0.0, (0.0, 0.0, 0.0), 0.0)
    with pytest.raises(PoseError, match="setpoint"):
        controller.set_setpoint((0.0, bad, 0.0))
    for pose in ((bad, (0.0, 0.0, 0.0), 0.0), (0.01, (0.0, 0.0, bad), 0.0), (0.01, (0.0, 0.0, 0.0), bad)):
        with pytest.raises(PoseError, match="pose"):
            controller.update(*pose)
    assert controller.setpoint_m == (40.0, 0.0, 0.0)
    assert controller.update(0.01, (0.0, 0.0, 0.0), 0.0).velocity_m_s == pytest.approx((0.02, 0.0, 0.0))


@pytest.mark.table("far", [1e308, -1.1e6])
def test_a_setpoint_beyond_all_reason_is_refused_in_a_sentence(far):
    controller = PositionController()
    controller.set_setpoint((1e6, 0.0, 0.0))
    with pytest.raises(PoseError, match=r"setpoint has a coordinate beyond 1e\+06 m; it is ignored\."):
        controller.set_setpoint((0.0, far, 0.0))
    assert controller.setpoint_m == (1e6, 0.0, 0.0)
