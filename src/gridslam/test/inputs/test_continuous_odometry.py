"""Odometry that jumps: the vehicle counts as at rest, and what follows goes on from there."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from gridslam import ScanError, se2
from gridslam.inputs.continuous_odometry import ContinuousOdometry

poses = st.tuples(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0), st.floats(-3.1, 3.1))
steps = st.tuples(st.floats(-0.4, 0.4), st.floats(-0.2, 0.2), st.floats(-0.4, 0.4))


def followed(readings):
    """(poses (n, 3), sentences) of readings (stamp, pose)."""
    said = []
    odometry = ContinuousOdometry(said.append)
    return np.array([odometry.follow(*reading) for reading in readings]), said, odometry


def assert_same(poses, expected):
    difference = np.asarray(poses) - np.asarray(expected)
    difference[..., 2] = se2.wrap(difference[..., 2])
    np.testing.assert_allclose(difference, 0.0, atol=1e-9)


@given(poses, st.lists(steps, min_size=1, max_size=8))
def test_odometry_that_does_not_jump_passes(start, moves):
    readings = [start]
    for move in moves:
        readings.append(se2.compose(readings[-1], move))
    found, said, odometry = followed([(0.1 * index, pose) for index, pose in enumerate(readings)])
    assert_same(found, readings)
    assert said == []
    assert_same(odometry.odom_in_continuous, np.zeros(3))


@given(poses, poses, steps)
def test_a_reset_is_no_motion_and_later_motion_counts(before, after, move):
    x, y, yaw = se2.between(before, after)
    most_m, most_rad = 0.5 + 20.0 * 0.025, 0.5 + 12.0 * 0.025
    assume(abs(math.hypot(x, y) - most_m) > 1e-6 and abs(abs(yaw) - most_rad) > 1e-6)  # or rounding decides
    jumped = math.hypot(x, y) > most_m or abs(yaw) > most_rad
    readings = [(1.0, before), (1.025, after), (1.05, se2.compose(after, move))]
    found, said, odometry = followed(readings)
    assert_same(found[1], before if jumped else after)
    assert_same(found[2], se2.compose(found[1], move))
    assert len(said) == jumped
    assert_same(se2.compose(odometry.odom_in_continuous, after), found[1])


def test_a_long_silence_excuses_a_long_way():
    found, said, _ = followed([(0.0, (0.0, 0.0, 0.0)), (60.0, (100.0, 0.0, 3.0))])
    assert_same(found[1], (100.0, 0.0, 3.0))
    assert said == []


def test_the_warning_says_how_far():
    _, said, _ = followed([(0.0, (0.0, 0.0, 0.0)), (0.1, (30.0, 40.0, 0.0))])
    assert said[0].startswith("Odometry jumped by 50.00 m and 0 degrees in 0.100 s")


def test_a_clock_that_went_back_is_told_of():
    _, said, _ = followed([(105.0, (0.0, 0.0, 0.0)), (50.0, (30.0, 40.0, 0.0))])
    assert said[0].startswith(
        "Odometry jumped by 50.00 m and 0 degrees while the clock went back by 55.000 s"
    )


def drive(way_m, turn_rad=0.0, count=20, every_s=2.5):
    """Readings (stamp, pose) of a vehicle that moves by so much from one to the next."""
    poses = [np.zeros(3)]
    for _ in range(count):
        poses.append(se2.compose(poses[-1], (way_m, 0.0, turn_rad)))
    return [(every_s * index, pose) for index, pose in enumerate(poses)]


@pytest.mark.table("first", [(0.0, 0.0, 0.0), (0.4, -0.2, 0.05)])
@pytest.mark.table("origin", [(0.0, 0.0, 0.0), (-3.0, 5.0, 2.0)])
def test_slow_scans_excuse_no_odometry_that_begins_anew(first, origin):
    # Given scans every 2.5 s, 0.4 m apart; 8 m off, odometry begins anew at zero, or where it began at first
    readings = [(stamp_s, se2.compose(origin, pose)) for stamp_s, pose in drive(0.4)]
    begun = np.zeros(3) if first == (0.0, 0.0, 0.0) else se2.compose(origin, first)
    readings += [(52.5, begun), (55.0, se2.compose(begun, (0.4, 0.0, 0.0)))]
    found, said, odometry = followed(readings)
    # Then the vehicle was at rest meanwhile, and its place is in doubt for as much as it may have moved
    assert_same(found[-2], readings[-3][1])
    assert_same(found[-1], se2.compose(readings[-3][1], (0.4, 0.0, 0.0)))
    assert len(said) == 1
    assert odometry.doubt is None
    found, _, odometry = followed(readings[:-1])
    assert odometry.doubt.reason == "odometry has jumped"
    assert odometry.doubt.deviations == pytest.approx((0.4, 0.4, 0.0))


@given(st.floats(0.1, 2.0), st.integers(12, 40))
@settings(max_examples=20)
def test_a_round_trip_through_the_origin_is_no_restart(way_m, count):
    found, said, odometry = followed(drive(way_m, 2.0 * math.pi / count, 3 * count))
    assert_same(found[-1], np.zeros(3))
    assert (said, odometry.doubt) == ([], None)


def test_a_silence_leaves_a_part_of_the_way_unknown():
    # Given a vehicle at 0.4 m/s; 60 s later odometry says that it is 3 m farther
    readings = drive(0.4, every_s=1.0)
    readings.append((80.0, se2.compose(readings[-1][1], (3.0, 0.0, 0.0))))
    found, said, odometry = followed(readings)
    # Then that is taken as it is, and doubted: 24 m may be missing
    assert_same(found[-1], readings[-1][1])
    assert said == []
    assert odometry.doubt.reason == "60.0 s before this scan are missing"
    assert odometry.doubt.deviations == pytest.approx((0.1 * 24**0.5, 0.1 * 24**0.5, 0.3))
    # And a pause that is as long as earlier ones is usual
    readings.append((140.0, readings[-1][1]))
    assert followed(readings)[2].doubt is None


@pytest.mark.table(("way_m", "turn_rad", "is_known"), [(3.2, 1.5, True), (1.5, 0.0, False)])
def test_odometry_that_has_moved_as_usual_in_a_silence_tells_the_whole_way(way_m, turn_rad, is_known):
    # given a vehicle at 0.4 m/s; in 8 s without scans odometry has moved by 3.2 m, or by less than half of it
    readings = drive(0.4, every_s=1.0)
    readings.append((28.0, se2.compose(readings[-1][1], (way_m, 0.0, turn_rad))))
    if not is_known:
        readings[-1] = (48.0, readings[-1][1])
    doubt = followed(readings)[2].doubt
    # then nothing of the way is missing but scans, or somebody may have carried the vehicle
    assert doubt.is_way_known == is_known
    assert (doubt.deviations == (0.0, 0.0, 0.0)) == is_known


def test_a_step_that_is_much_longer_than_any_before_is_doubted():
    readings = drive(0.4)
    readings.append((52.5, se2.compose(readings[-1][1], (6.9, 0.0, 0.0))))
    found, said, odometry = followed(readings)
    assert_same(found[-1], readings[-1][1])
    assert said == []
    assert odometry.doubt.reason == "odometry has moved by 6.90 m and 0 degrees at once"


def test_a_way_home_without_readings_is_no_jump_after_a_slow_one():
    # Given a small robot, ten readings a second: it drives off at 0.4 m/s, and turns on the spot at 3 rad/s
    readings = [(0.1 * i, (0.04 * i, 0.0, 0.0)) for i in range(40)]
    readings += [(4.0 + 0.1 * i, (1.6, 0.0, 0.3 * i)) for i in range(10)]
    # and that comes on by 0.3 m only while readings lack for 5 s
    x, y, yaw = se2.compose((1.6, 0.0, 2.7), (0.3, 0.0, 0.0))
    readings.append((10.0, (x, y, yaw)))
    # When readings lack for 5 s again, in which it comes to where it began, and turns
    readings.append((15.0, (0.1, 0.0, 0.05)))
    found, said, _ = followed(readings)
    # Then odometry is believed: it is far less than the robot can do in this time
    assert said == []
    assert_same(found[-1], readings[-1][1])


@given(poses, poses, steps)
def test_a_restored_state_goes_on_as_if_nothing_had_been(before, after, move):
    *_, odometry = followed([(1.0, before), (1.025, after)])
    restored = ContinuousOdometry(lambda sentence: None)
    restored.restore(odometry.state())
    reading = (1.05, se2.compose(after, move))
    np.testing.assert_array_equal(restored.follow(*reading), odometry.follow(*reading))


@pytest.mark.table("pose", [(math.nan, 0.0, 0.0), (0.0, math.inf, 0.0), (0.0, 0.0)])
def test_a_pose_that_is_none_is_refused(pose):
    with pytest.raises(ScanError, match="finite"):
        followed([(0.0, pose)])


def test_a_silence_does_not_make_the_next_one_usual():
    # given ten scans a second at 1 m/s, which lacked for 6 s in between
    stamps_s = np.concatenate([np.arange(0.0, 15.0, 0.1), np.arange(21.0, 30.0, 0.1)])
    _, _, odometry = followed([(stamp_s, (stamp_s, 0.0, 0.0)) for stamp_s in stamps_s])
    assert not odometry.is_silence(4.0)
    assert odometry.is_silence(6.0)
    # and a scan in 3 s is usual for a robot that scans so
    _, _, odometry = followed([(3.0 * k, (3.0 * k, 0.0, 0.0)) for k in range(20)])
    assert not odometry.is_silence(9.0)
