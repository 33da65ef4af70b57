"""The pose for the flight controller is good and continuous, or there is none and the state says why."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from inspection_tools import VisionPose, VisionPoseParameters, VisionState
from inspection_tools.vision_pose import Motion

COVARIANCE = np.diag([1e-4, 1e-4, 1e-4, 1e-6, 1e-6, 1e-6]).ravel().tolist()
PERIOD_S = 0.025
THERE = (0.5, 0.0, 2.0)  # a second after the start of `flight`


def motion(time_s, position=(0.0, 0.0, 2.0), yaw=0.0, covariance=COVARIANCE, velocity=(0.5, 0.0, 0.0)):
    orientation = (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
    return Motion(
        round(1e9 * time_s), position, orientation, velocity, (0.0, 0.0, 0.0), covariance, COVARIANCE
    )


def feed(vision, motions):
    """Give each at its own time. Return all that goes out."""
    return [sent for given in motions for sent in vision.update(given, given.stamp_s)]


def flight(start_s, seconds, place=(0.0, 0.0, 2.0), period_s=PERIOD_S):
    """Along x at 0.5 m/s."""
    times = [start_s + period_s * i for i in range(round(seconds / period_s))]
    return [motion(t, (place[0] + 0.5 * (t - start_s), place[1], place[2])) for t in times]


UNKNOWN_HEIGHT = np.diag([1e-4, 1e-4, 1.0, 1e-6, 1e-6, 1e-6]).ravel().tolist()


def deviation(position_m=0.01, yaw_rad=0.001):
    return np.diag([position_m**2] * 3 + [1e-6, 1e-6, yaw_rad**2]).ravel().tolist()


def test_good_odometry_goes_out_as_it_came_with_its_own_stamp():
    vision = VisionPose()
    assert vision.state is VisionState.WAITING
    given = flight(5.0, 1.0)
    assert feed(vision, given) == given
    assert vision.state is VisionState.GOOD


@pytest.mark.table("rate_hz", [10.0, 15.0, 20.0])
def test_a_slow_lidars_poses_are_filled_up_and_say_no_more_than_they_did(rate_hz):
    vision = VisionPose(VisionPoseParameters(min_rate=30.0))
    given = flight(5.0, 2.0, period_s=1.0 / rate_hz)
    sent = feed(vision, given)
    times = np.array([each.stamp_s for each in sent])
    assert np.diff(times).max() <= 1.0 / 30.0 + 1e-6
    assert [each.position_m[0] for each in sent] == pytest.approx(0.5 * (times - 5.0), abs=1e-6)
    count = round((len(sent) - 1) / (len(given) - 1))
    assert sent[-1].pose_covariance == pytest.approx([count * value for value in COVARIANCE])
    assert sent[-1].stamp_ns == given[-1].stamp_ns


def test_headings_between_two_poses_take_the_short_way():
    vision = VisionPose()
    vision.update(motion(0.0, yaw=3.1), 0.0)
    half, whole = vision.update(motion(0.05, yaw=-3.1), 0.05)
    headings = [
        2.0 * math.atan2(each.orientation_xyzw[2], each.orientation_xyzw[3]) for each in (half, whole)
    ]
    assert [math.cos(heading) for heading in headings] == pytest.approx([-1.0, math.cos(3.1)])


@pytest.mark.table(
    ("bad", "now_s", "state", "words"),
    [
        (motion(6.0, covariance=[math.nan] * 36), 6.0, VisionState.INVALID, "not finite"),
        (motion(6.0, covariance=[-1.0] * 36), 6.0, VisionState.INVALID, "negative"),
        (motion(6.0, THERE), 6.4, VisionState.STALE, "0.40 s old"),
        (motion(6.0, THERE, covariance=deviation(position_m=0.6)), 6.0, VisionState.UNCERTAIN, "0.60 m"),
        (motion(6.0, THERE, covariance=UNKNOWN_HEIGHT), 6.0, VisionState.UNCERTAIN, "height is uncertain"),
        (motion(6.0, THERE, covariance=deviation(yaw_rad=0.4)), 6.0, VisionState.UNCERTAIN, "0.40 rad"),
        (motion(6.0, (10.4875, 0.0, 2.0)), 6.0, VisionState.JUMPED, "jumped by 10.00 m"),
        (motion(6.0, THERE, yaw=1.0), 6.0, VisionState.JUMPED, "1.00 rad"),
    ],
)
def test_a_bad_pose_does_not_go_out_and_the_state_says_why(bad, now_s, state, words):
    vision = VisionPose()
    feed(vision, flight(5.0, 1.0))
    assert vision.update(bad, now_s) == []
    assert vision.state is state
    assert words in vision.reason
    assert vision.reason.endswith(".")


def test_what_is_no_jump_is_good_again_with_the_next_pose():
    vision = VisionPose()
    feed(vision, flight(5.0, 1.0))
    vision.refuse("The pose is of another frame.")
    assert vision.state is VisionState.INVALID
    assert feed(vision, [motion(6.1)])
    assert vision.state is VisionState.GOOD


def test_silence_is_noticed_and_a_short_gap_is_flown_over():
    vision = VisionPose(VisionPoseParameters(max_age=0.3))
    given = flight(5.0, 1.0)
    feed(vision, given)
    vision.watch(given[-1].stamp_s + 0.29)
    assert vision.state is VisionState.GOOD
    vision.watch(given[-1].stamp_s + 0.31)
    assert (vision.state, vision.reason) == (VisionState.STALE, "No odometry has come for 0.31 s.")
    late = motion(given[-1].stamp_s + 0.5, (0.7, 0.0, 2.0))
    assert feed(vision, [late]) == [late]  # a gap so long is not filled


def turned(yaw_rad, given, origin=(0.0, 0.0, 0.0)):
    """The same flight, told by odometry whose frame is another one."""
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    x, y, z = given.position_m
    place = (origin[0] + cos * x - sin * y, origin[1] + sin * x + cos * y, origin[2] + z)
    heading = 2.0 * math.atan2(given.orientation_xyzw[2], given.orientation_xyzw[3]) + yaw_rad
    orientation = (0.0, 0.0, math.sin(0.5 * heading), math.cos(0.5 * heading))
    return replace(given, position_m=place, orientation_xyzw=orientation)


@pytest.mark.table("speed_m_s", [0.0, 0.5, 2.0])
@pytest.mark.table("yaw_rad", [0.0, 2.0, math.pi])
def test_after_jumps_the_pose_goes_on_where_the_uav_is(yaw_rad, speed_m_s):
    """The odometry starts elsewhere, twice: what goes out is the flight, as if it had not."""
    vision = VisionPose(VisionPoseParameters(settle_time=0.5))
    velocity = (speed_m_s, 0.0, 0.0)
    whole = [
        motion(5.0 + t, (speed_m_s * t, 0.0, 2.0), velocity=velocity) for t in np.arange(0.0, 6.0, PERIOD_S)
    ]
    told = [
        each
        if each.stamp_s < 8.0
        else turned(yaw_rad, each, (40.0, 3.0, 1.0) if each.stamp_s < 8.2 else (-20.0, 8.0, 0.0))
        for each in whole
    ]
    sent = feed(vision, told)
    gap = next(i for i, each in enumerate(sent) if each.stamp_s >= 8.0)
    assert sent[gap].stamp_s == pytest.approx(8.7, abs=PERIOD_S)  # it has settled after the second jump
    truth = {each.stamp_ns: each for each in whole}
    for each in sent[gap - 1 :]:
        assert each.position_m == pytest.approx(truth[each.stamp_ns].position_m, abs=1e-6)
        assert abs(each.orientation_xyzw[3]) == pytest.approx(1.0)
        assert each.pose_covariance == pytest.approx(COVARIANCE, abs=1e-12)


def test_a_turn_goes_on_through_a_jump():
    """At 1 rad/s on a circle of 1 m: way and heading between the last pose before and the first after it."""
    vision, truth = VisionPose(VisionPoseParameters(settle_time=0.5)), {}
    for t in np.arange(5.0, 9.0, PERIOD_S):
        turn = t - 5.0
        each = replace(
            motion(t, (math.sin(turn), 1.0 - math.cos(turn), 2.0), turn, velocity=(1.0, 0.0, 0.0)),
            rates_rad_s=(0.0, 0.0, 1.0),
        )
        truth[each.stamp_ns] = each
        sent = feed(vision, [each if t < 7.0 else turned(1.0, each, (9.0, 9.0, 0.0))])
    assert sent[0].position_m == pytest.approx(truth[sent[0].stamp_ns].position_m, abs=0.002)
    assert sent[0].orientation_xyzw == pytest.approx(truth[sent[0].stamp_ns].orientation_xyzw, abs=1e-6)


@pytest.mark.table("velocity", [(math.nan, 0.0, 0.0), (50.0, 0.0, 0.0)])
def test_a_velocity_that_cannot_be_is_not_flown_on_with(velocity):
    vision = VisionPose(VisionPoseParameters(settle_time=0.0))
    vision.update(motion(5.0, velocity=velocity), 5.0)
    (sent,) = (
        vision.update(motion(5.025, (9.0, 0.0, 2.0), velocity=velocity), 5.025)[-1:]
        or feed(vision, [motion(5.05, (9.0, 0.0, 2.0))])[-1:]
    )
    assert sent.position_m == pytest.approx((0.0, 0.0, 2.0))


def test_one_pose_that_is_wrong_leaves_nothing_behind():
    vision = VisionPose()
    given = flight(5.0, 4.0)
    given[80] = replace(given[80], position_m=(9.0, 9.0, 9.0), velocity_m_s=(0.0, 0.0, 0.0))
    last = feed(vision, given)[-1]
    # It told no velocity, so the way of one period is not known
    assert last.position_m == pytest.approx(given[-1].position_m, abs=0.5 * PERIOD_S + 1e-6)


def test_a_second_of_the_same_stamp_and_an_older_one_are_left_out():
    vision = VisionPose()
    feed(vision, flight(5.0, 1.0))
    assert feed(vision, [motion(5.5), motion(5.975)]) == []
    assert vision.state is VisionState.GOOD


def test_a_reset_starts_anew():
    vision = VisionPose()
    feed(vision, flight(5.0, 1.0))
    vision.reset()
    assert vision.state is VisionState.WAITING
    assert feed(vision, flight(0.0, 1.0, (30.0, 0.0, 2.0)))[0].position_m == (30.0, 0.0, 2.0)


def test_at_the_start_the_first_sure_pose_goes_out():
    vision = VisionPose(VisionPoseParameters(sure_time=0.5))
    feed(vision, [replace(each, pose_covariance=UNKNOWN_HEIGHT) for each in flight(5.0, 1.0)])
    assert vision.state is VisionState.UNCERTAIN
    given = flight(6.0, 1.0, THERE)
    assert feed(vision, given) == given


def test_a_pose_that_was_lost_goes_out_again_when_it_has_been_sure_for_a_time():
    """Odometry that is uncertain by turns, as where the lidar sees too little: 0.1 s lost, 0.3 s sure."""
    vision = VisionPose(VisionPoseParameters(sure_time=0.5))
    feed(vision, flight(5.0, 1.0))
    by_turns = [
        replace(each, pose_covariance=deviation(position_m=0.6)) if i % 16 < 4 else each
        for i, each in enumerate(flight(6.0, 4.0, THERE))
    ]
    assert feed(vision, by_turns) == []
    assert vision.state is VisionState.UNCERTAIN
    # The last uncertain pose is of 9.675 s, as 9.6 s begins a turn
    sent = feed(vision, flight(10.0, 1.0, (2.5, 0.0, 2.0)))
    assert sent[0].stamp_s == pytest.approx(9.675 + 0.5)
    assert vision.state is VisionState.GOOD
