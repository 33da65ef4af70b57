"""SLAM's correction reaches the pose slowly: no commanded velocity jumps, and in the end all of it counts."""

from __future__ import annotations

import math

import pytest

from flight_basics.correction import CorrectionParameters, SlowCorrection
from flight_basics.errors import ParameterError
from flight_basics.geometry import multiply, rotate, yaw_of
from inspection_tools import PositionController, PositionControllerParameters

STEP_S = 0.025


def about_z(angle):
    return (0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2))


NONE = ((0.0, 0.0, 0.0), about_z(0.0))


def test_the_first_correction_counts_at_once_as_a_rigid_transform():
    shift, turn = (10.0, -2.0, 0.5), about_z(0.7)
    position, yaw = SlowCorrection().apply(1.0, ((-3.0, 4.0, 2.0), 3.0), shift, turn)
    expected = [a + b for a, b in zip(shift, rotate(turn, (-3.0, 4.0, 2.0)))]
    assert position == pytest.approx(expected)
    assert yaw == pytest.approx(yaw_of(multiply(turn, about_z(3.0))))


def test_a_correction_moves_the_pose_at_the_limited_speed_to_its_end():
    correction = SlowCorrection(CorrectionParameters(correction_speed=0.15, correction_turn_rate=0.08))
    pose = ((5.0, 1.0, 2.0), 0.2)
    before, _ = correction.apply(0.0, pose, *NONE)
    shift, turn = (1.0, 0.0, 0.0), about_z(0.3)
    goal = [a + b for a, b in zip(shift, rotate(turn, pose[0]))]
    time_to_move_s = math.dist(before, goal) / 0.15
    for step in range(1, 1000):
        here, yaw = correction.apply(STEP_S * step, pose, shift, turn)
        assert math.dist(here, before) <= 0.15 * STEP_S + 1e-12
        before = here
        if STEP_S * step < time_to_move_s - STEP_S:
            assert here != pytest.approx(goal)
    assert here == pytest.approx(goal)
    assert yaw == pytest.approx(0.5)


@pytest.mark.table("goal_m", [(0.0, 0.0, 2.0), (20.0, 5.0, 2.0)])  # while it hovers, and in flight
def test_a_loop_closure_moves_the_goal_and_never_steps_the_velocity(goal_m):
    """A UAV that flies what it is told. SLAM shifts it by 2 m and turns it by 0.4 rad in an instant."""
    controller = PositionController(PositionControllerParameters())
    controller.set_setpoint(goal_m)
    correction, place, commands = SlowCorrection(), (0.0, 0.0, 2.0), []
    for step in range(1200):
        slam = NONE if step < 200 else ((1.2, -1.6, 0.0), about_z(0.4))
        position, yaw = correction.apply(STEP_S * step, (place, 0.0), *slam)
        velocity = controller.update(STEP_S * step, position, yaw).velocity_m_s  # its body is never turned
        commands.append(velocity)
        place = tuple(p + STEP_S * v for p, v in zip(place, velocity))
    steps = [math.dist(a, b) for a, b in zip(commands, commands[1:])]
    assert max(steps) <= 2.0 * STEP_S + 0.08 * STEP_S * 2.0 + 1e-9  # max_acceleration, and the slow turn
    if goal_m[0] == 0.0:
        assert max(math.hypot(*velocity) for velocity in commands) <= 0.2
    position, _ = correction.apply(1e3, (place, 0.0), *slam)
    assert position == pytest.approx(goal_m, abs=0.05)


def test_a_jump_of_the_clock_or_zero_speed_takes_the_correction_at_once():
    correction = SlowCorrection()
    correction.apply(10.0, ((0.0, 0.0, 0.0), 0.0), *NONE)
    shift = ((3.0, 0.0, 0.0), about_z(0.0))
    assert correction.apply(1.0, ((0.0, 0.0, 0.0), 0.0), *shift)[0] == (3.0, 0.0, 0.0)
    correction = SlowCorrection(CorrectionParameters(correction_speed=0.0))
    correction.apply(10.0, ((0.0, 0.0, 0.0), 0.0), *NONE)
    assert correction.apply(10.1, ((0.0, 0.0, 0.0), 0.0), *shift)[0] == (3.0, 0.0, 0.0)


def test_parameters_are_checked():
    with pytest.raises(ParameterError, match="correction_turn_rate"):
        CorrectionParameters(correction_turn_rate=0.0)
