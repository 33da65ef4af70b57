"""The stop of a UAV that has lost its external pose."""

import math

import pytest

from simulation_tools.geometry import Pose
from simulation_tools.publisher import PublisherParameters
from simulation_tools.publisher.brake import Brake
from simulation_tools.publisher.history import History

P = PublisherParameters(
    brake_gain=2.0,
    brake_lead_s=0.2,
    late_gain_per_s=10.0,
    hard_time_s=0.3,
    rest_gain=0.5,
    brake_time_s=1.0,
    brake_speed_m_s=4.0,
    brake_pose_age_s=0.04,
    hold_speed_m_s=0.15,
)
MS = 1_000_000
NOW_NS = 10_000 * MS
AGE_S = 0.09
"""Of the velocity: that of the newest pose, and half the time between two."""
G_M_S2 = 9.81
IN_TIME_S = 0.12


def poses(east=0.0, north=0.0, pitch=0.0, yaw=math.pi / 2, turn=0.0, until_ns=NOW_NS - 40 * MS):
    """Return two poses, 0.1 s apart: m/s, the last one's lean forwards (rad), heading, rad/s."""
    history = History()
    for ago_s in (0.1, 0.0):
        stamp_ns = until_ns - round(1e9 * ago_s)
        orientation = 0.0, pitch, yaw - turn * ago_s
        history.add(stamp_ns, Pose.from_xyz_rpy(5.0 - east * ago_s, -north * ago_s, 2.0, *orientation))
    return history


@pytest.mark.parametrize(
    ("speed_east", "speed_north", "expected"),
    [
        (1.0, 0.0, (0.0, 2.0, 0.0)),  # to the right of a UAV that looks north
        (0.0, 0.5, (-1.0, 0.0, 0.0)),
        (0.0, 3.0, (-4.0, 0.0, 0.0)),  # at most brake_speed_m_s
        (0.0, 0.1, (0.0, 0.0, 0.0)),  # it hovers
    ],
)
def test_a_level_uav_is_commanded_against_its_own_speed(speed_east, speed_north, expected):
    stop = Brake(NOW_NS, IN_TIME_S, poses(speed_east, speed_north), P)
    assert stop.velocity(NOW_NS) == pytest.approx(expected)


def test_a_late_brake_is_harder():
    late = Brake(NOW_NS, IN_TIME_S + 0.05, poses(north=1.0), P)
    assert late.velocity(NOW_NS) == pytest.approx((-(2.0 + 10.0 * 0.05), 0.0, 0.0))


def test_its_lean_counts_until_a_new_command_shows():
    # Given 1 m/s to the north, and a lean back of 2 m/s2
    lean = poses(north=1.0, pitch=-math.atan(2.0 / G_M_S2))
    # Then it will have lost 2 m/s2 for 0.09 s, which have passed, and brake_lead_s
    coming = 1.0 - 2.0 * (AGE_S + 0.2)
    assert Brake(NOW_NS, IN_TIME_S, lean, P).velocity(NOW_NS) == pytest.approx((-2.0 * coming, 0.0, 0.0))


def test_as_soon_as_its_lean_suffices_it_is_righted_and_later_braked_less():
    history = poses(north=1.0)
    stop = Brake(NOW_NS, IN_TIME_S, history, P)
    assert stop.velocity(NOW_NS)[0] == pytest.approx(-2.0)

    def at(after_ms, speed, slows_by):
        """Return what is commanded when it has this speed and loses so much of it, m/s2."""
        now_ns = NOW_NS + after_ms * MS
        newer = poses(north=speed, pitch=-math.atan(slows_by / G_M_S2), until_ns=now_ns - 40 * MS)
        history.clear()
        for ago_s in (0.1, 0.0):
            stamp_ns = now_ns - 40 * MS - round(1e9 * ago_s)
            history.add(stamp_ns, newer.at(stamp_ns))
        return stop.velocity(now_ns)[0]

    # While 3 m/s2 take less than 1 m/s within the 0.29 s, brake_gain counts
    assert at(100, 1.0, 3.0) == pytest.approx(-2.0 * (1.0 - 3.0 * (AGE_S + 0.2)))
    # When 4 m/s2 take more, it is commanded to stand, not to fly on
    assert at(200, 1.0, 4.0) == pytest.approx(0.0)
    # After hard_time_s only rest_gain counts
    assert at(400, 0.4, 0.0) == pytest.approx(-0.5 * 0.4)
    # And after brake_time_s it is commanded to stand
    assert at(1001, 0.4, 0.0) == 0.0


def test_a_uav_that_turns_has_turned_on_when_it_brakes():
    stop = Brake(NOW_NS, IN_TIME_S, poses(north=0.5, turn=2.0), P)
    turned = 2.0 * (0.04 + 0.05)  # since the newest pose, and until it turns no more
    assert stop.velocity(NOW_NS) == pytest.approx((-math.cos(turned), math.sin(turned), 0.0))


def test_in_a_curve_it_brakes_against_the_velocity_to_come():
    # Given 0.5 m/s to the north, and a lean to the east of 2 m/s2
    history = History()
    for ago_s in (0.1, 0.0):
        lean = Pose.from_xyz_rpy(0.0, -0.5 * ago_s, 2.0, 0.0, math.atan(2.0 / G_M_S2), 0.0)
        history.add(NOW_NS - 40 * MS - round(1e9 * ago_s), lean)
    # Then it brakes also against what it will have to the east (ahead; north is to its left)
    expected = -2.0 * 2.0 * (AGE_S + 0.2), -2.0 * 0.5, 0.0
    assert Brake(NOW_NS, IN_TIME_S, history, P).velocity(NOW_NS) == pytest.approx(expected)


def test_what_is_sideways_is_braked_when_nothing_else_is_left():
    history = poses(north=1.0)
    stop = Brake(NOW_NS, IN_TIME_S, history, P)
    history.clear()
    for ago_s in (0.1, 0.0):
        drift = Pose.from_xyz_rpy(-0.2 * ago_s, 0.3 * ago_s, 2.0, 0.0, 0.0, math.pi / 2)  # south-east
        history.add(NOW_NS + 360 * MS - round(1e9 * ago_s), drift)
    assert stop.velocity(NOW_NS + 400 * MS) == pytest.approx((0.0, 0.5 * 0.2, 0.0))  # to the west, its left


def test_without_two_poses_it_is_commanded_to_stand():
    history = History()
    assert Brake(NOW_NS, IN_TIME_S, history, P).velocity(NOW_NS) == (0.0, 0.0, 0.0)
    history.add(NOW_NS - 50 * MS, Pose.from_xyz_rpy(5.0, 1.0, 2.0, 0.0, 0.0, 0.0))
    assert Brake(NOW_NS, IN_TIME_S, history, P).velocity(NOW_NS) == (0.0, 0.0, 0.0)


def test_when_the_poses_end_it_is_commanded_to_stand():
    stop = Brake(NOW_NS, IN_TIME_S, poses(north=1.0), P)
    assert stop.velocity(NOW_NS + 150 * MS)[0] < 0.0
    assert stop.velocity(NOW_NS + 170 * MS) == (0.0, 0.0, 0.0)  # the newest is 0.21 s old
