"""The stop of a UAV that has lost its pose."""

import math

import pytest

from simulation_tools.geometry import Pose
from simulation_tools.publisher import PublisherParameters
from simulation_tools.publisher.brake import Brake

P = PublisherParameters(brake_gain=2.0, brake_time_s=0.2, brake_speed_m_s=4.0, hold_speed_m_s=0.15)
NOW_NS = 10_000_000_000
BRAKES_S = 0.15
"""From the newest pose until PX4 leans: 0.1 s to the loss, and 0.05 s more."""


def pose(x, y, yaw=math.pi / 2):
    return Pose.from_xyz_rpy(x, y, 2.0, 0.0, 0.0, yaw)


def brake(*poses, apart_s=0.1):
    """Return the brake of a UAV with these poses, the newest 0.1 s old."""
    ages_s = [0.1 + apart_s * i for i in reversed(range(len(poses)))]
    return Brake(NOW_NS, [(NOW_NS - round(1e9 * age), p) for age, p in zip(ages_s, poses)], P)


@pytest.mark.parametrize(
    ("speed_east", "speed_north", "expected"),
    [
        (1.0, 0.0, (0.0, 2.0, 0.0)),  # to the right of a UAV that looks north
        (0.0, 0.5, (-1.0, 0.0, 0.0)),
        (0.0, 0.1, (0.0, 0.0, 0.0)),  # it hovers
    ],
)
@pytest.mark.parametrize("known", [2, 3])
def test_it_is_commanded_against_its_own_speed_then_to_stand(speed_east, speed_north, expected, known):
    stop = brake(*(pose(0.1 * i * speed_east, 0.1 * i * speed_north) for i in range(known)))
    lasts_s = 0.2 * math.sqrt(math.hypot(speed_east, speed_north))  # brake_time_s from 1 m/s
    assert stop.velocity(NOW_NS + round(1e9 * lasts_s) - 1_000_000) == pytest.approx(expected)
    assert stop.velocity(NOW_NS + round(1e9 * lasts_s) + 1_000) == (0.0, 0.0, 0.0)


def test_a_fast_uav_is_not_commanded_more_but_for_longer():
    stop = brake(pose(5.0, 0.2), pose(5.0, 0.6), pose(5.0, 1.0))  # 4 m/s ahead: 2 * 4 m/s would be 8
    assert stop.velocity(NOW_NS + 390_000_000) == pytest.approx((-4.0, 0.0, 0.0))
    assert stop.velocity(NOW_NS + 410_000_000) == (0.0, 0.0, 0.0)


def test_a_uav_that_turns_has_turned_on_when_it_brakes():
    # Given 0.5 m/s to the north, and a turn of 2 rad/s to the left
    stop = brake(*(pose(5.0, 0.05 * i, math.pi / 2 - 0.2 * (2 - i)) for i in range(3)))
    # Then north is 2 rad/s * 0.15 s to the right of ahead
    turned = 2.0 * BRAKES_S
    assert stop.velocity(NOW_NS) == pytest.approx((-math.cos(turned), math.sin(turned), 0.0))


def test_in_a_curve_it_brakes_against_the_velocity_to_come():
    # Given 0.6 m/s to the east at the second pose, and 2 m/s2 to the north
    times_s = (-0.1, 0.0, 0.1)
    stop = brake(*(pose(0.6 * t, t**2, yaw=0.0) for t in times_s))
    # Then it moves to the north with 2 m/s2 * 0.25 s when it brakes
    assert stop.velocity(NOW_NS) == pytest.approx((-1.2, -2.0 * 2.0 * (0.1 + BRAKES_S), 0.0))


def test_the_poses_need_not_be_evenly_apart():
    stamps_s = (-0.3, -0.27, -0.1)
    poses = [pose(0.5 * (t + 0.3) ** 2, 0.0, yaw=0.0) for t in stamps_s]  # 1 m/s2, from rest 0.3 s before
    stop = Brake(NOW_NS, [(NOW_NS + round(1e9 * t), p) for t, p in zip(stamps_s, poses)], P)
    assert stop.velocity(NOW_NS) == pytest.approx((-2.0 * 0.35, 0.0, 0.0))


def test_a_jump_of_the_estimate_is_not_taken_for_a_curve():
    stop = brake(pose(0.0, 0.0, 0.0), pose(0.0, 0.0, 0.0), pose(0.1, 0.0, 0.0))  # 10 m/s2, or a jump of 0.1 m
    speed = 0.1 / 0.2 + 3.0 * (0.1 + BRAKES_S)  # the mean, and 3 m/s2 at most
    assert stop.velocity(NOW_NS) == pytest.approx((-2.0 * speed, 0.0, 0.0))


@pytest.mark.parametrize("known", [0, 1])
def test_without_two_poses_it_is_commanded_to_stand(known):
    assert brake(*known * [pose(5.0, 1.0)]).velocity(NOW_NS) == (0.0, 0.0, 0.0)
