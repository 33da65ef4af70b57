"""The stop of a UAV that has lost its pose."""

import math

import pytest

from simulation_tools.geometry import Pose
from simulation_tools.publisher import PublisherParameters
from simulation_tools.publisher.brake import Brake

P = PublisherParameters(brake_gain=2.0, brake_time_s=0.2, brake_speed_m_s=4.0, hold_speed_m_s=0.15)
NORTH = Pose.from_xyz_rpy(5.0, 1.0, 2.0, 0.0, 0.0, math.pi / 2)


def brake(before):
    return Brake(10_000_000_000, before, NORTH, 0.2, P)


@pytest.mark.parametrize(
    ("x", "y", "expected"),
    [
        (4.8, 1.0, (0.0, 2.0, 0.0)),  # 1 m/s to the east, which is to the right
        (5.0, 0.9, (-1.0, 0.0, 0.0)),  # 0.5 m/s ahead
        (5.0, 0.98, (0.0, 0.0, 0.0)),  # 0.1 m/s: it hovers
    ],
)
def test_it_is_commanded_against_its_own_speed_then_to_stand(x, y, expected):
    stop = brake(Pose.from_xyz_rpy(x, y, 1.0, 0.0, 0.0, math.pi / 2))
    assert stop.velocity(10_190_000_000) == pytest.approx(expected)
    assert stop.velocity(10_200_000_000) == (0.0, 0.0, 0.0)


def test_a_fast_uav_is_not_commanded_more_but_for_longer():
    stop = brake(Pose.from_xyz_rpy(5.0, 0.2, 2.0, 0.0, 0.0, math.pi / 2))  # 4 m/s ahead: 2 * 4 m/s would be 8
    assert stop.velocity(10_390_000_000) == pytest.approx((-4.0, 0.0, 0.0))
    assert stop.velocity(10_410_000_000) == (0.0, 0.0, 0.0)


def test_a_uav_that_turns_has_turned_on_since_its_last_known_pose():
    # Given 0.5 m/s to the north, and a turn of 0.4 rad in 0.2 s, so of 0.2 rad in decision_delay_s
    stop = brake(Pose.from_xyz_rpy(5.0, 0.9, 2.0, 0.0, 0.0, math.pi / 2 - 0.4))
    # Then north is 0.2 rad to the right of ahead
    assert stop.velocity(10_000_000_000) == pytest.approx((-math.cos(0.2), math.sin(0.2), 0.0))


def test_without_two_poses_it_is_commanded_to_stand():
    assert brake(None).velocity(10_000_000_000) == (0.0, 0.0, 0.0)
