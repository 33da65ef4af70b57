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


@settings(max_examples=40)
@given(poses, st.lists(steps, min_size=1, max_size=8))
def test_odometry_that_does_not_jump_passes(start, moves):
    readings = [start]
    for move in moves:
        readings.append(se2.compose(readings[-1], move))
    found, said, odometry = followed([(0.1 * index, pose) for index, pose in enumerate(readings)])
    assert_same(found, readings)
    assert said == []
    assert_same(odometry.odom_in_continuous, np.zeros(3))


@settings(max_examples=40)
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


@settings(max_examples=40)
@given(poses, poses, steps)
def test_a_restored_state_goes_on_as_if_nothing_had_been(before, after, move):
    *_, odometry = followed([(1.0, before), (1.025, after)])
    restored = ContinuousOdometry(lambda sentence: None)
    restored.restore(odometry.state())
    reading = (1.05, se2.compose(after, move))
    np.testing.assert_array_equal(restored.follow(*reading), odometry.follow(*reading))


@pytest.mark.parametrize("pose", [(math.nan, 0.0, 0.0), (0.0, math.inf, 0.0), (0.0, 0.0)])
def test_a_pose_that_is_none_is_refused(pose):
    with pytest.raises(ScanError, match="finite"):
        followed([(0.0, pose)])
