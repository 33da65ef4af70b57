"""gmapping's motion model: deviations by hand, and what is drawn by them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gridslam import SlamParameters, se2
from gridslam.filter.motion_model import DEVIATION_MIN, TOLD_MIN, Motion, growth, predict

PARAMETERS = SlamParameters(srr=0.1, srt=0.2, str=0.01, stt=0.05)


def moved(steps, start=(0.0, 0.0, 0.0)) -> Motion:
    """Steps (n, 3), each in the frame of the one before, as odometry tells of them."""
    motion, pose = Motion(np.array(start), 0.0), np.array(start)
    for step in steps:
        pose = se2.compose(pose, np.array(step))
        motion.add(pose, PARAMETERS)
    return motion


def test_deviations_worked_out_by_hand():
    # 3 m ahead, 1 m to the left, half a radian: gmapping's own sums
    expected = (0.1 * (3.0 + 0.3 * 1.0) + 0.01 * 0.5, 0.1 * (1.0 + 0.3 * 3.0) + 0.01 * 0.5)
    turn = 0.05 * 0.5 + 0.2 * np.sqrt(10.0)
    np.testing.assert_allclose(moved([(3.0, 1.0, 0.5)]).deviation, (*expected, turn))
    np.testing.assert_allclose(moved([(-3.0, -1.0, -0.5)]).deviation, (*expected, turn))


def test_who_stands_still_is_hardly_uncertain():
    np.testing.assert_array_equal(moved([(0.0, 0.0, 0.0)] * 50).deviation, DEVIATION_MIN)


@given(st.integers(1, 40), st.floats(0.05, 2.0))
def test_the_rate_of_scans_does_not_matter(parts, way_m):
    whole, cut = moved([(way_m, 0.0, 0.0)]), moved([(way_m / parts, 0.0, 0.0)] * parts)
    np.testing.assert_allclose(cut.deviation, whole.deviation, rtol=1e-9)
    assert cut.distance_m == pytest.approx(whole.distance_m)


def test_what_is_drawn_has_the_models_mean_and_covariance():
    motion = moved([(1.0, 0.2, 0.3)], start=(4.0, -2.0, 1.0))
    heading = 2.0
    poses = np.tile((1.0, -1.0, heading), (40_000, 1))
    prediction = predict(poses, motion, 7, np.random.default_rng(0))
    # predicted is odometry's own step from where the particle is
    np.testing.assert_allclose(
        prediction.predicted[0], se2.compose(poses[0], np.array((1.0, 0.2, 0.3))), atol=1e-12
    )
    # drawn has the model's deviations along and across the particle's heading
    cos, sin = np.cos(heading), np.sin(heading)
    turn = np.array(((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)))
    errors = prediction.drawn - prediction.predicted
    errors[:, 2] = se2.wrap(errors[:, 2])
    # the best particle has no noise
    assert not errors[7].any()
    covariance = turn @ np.diag(motion.deviation**2) @ turn.T
    np.testing.assert_allclose(errors.mean(axis=0), 0.0, atol=4.0 * motion.deviation.max() / 200.0)
    np.testing.assert_allclose(np.cov(errors.T), covariance, atol=0.03 * covariance.max())
    # and the information is the inverse of that
    np.testing.assert_allclose(prediction.information[0] @ covariance, np.eye(3), atol=1e-9)
    # and the log-density falls by half a squared deviation, along and across the heading
    off = prediction.predicted.copy()
    off[0, :2] += 2.0 * motion.deviation[0] * np.array((cos, sin))
    off[1, 2] += 3.0 * motion.deviation[2] - 2.0 * np.pi
    np.testing.assert_allclose(prediction.log_density(off)[:3], (-2.0, -4.5, 0.0), atol=1e-9)


POSES = st.lists(st.floats(-3.0, 3.0), min_size=6, max_size=6)
ENTRIES = st.lists(st.floats(0.0, 1.0), min_size=9, max_size=9)


@given(POSES, ENTRIES)
def test_growth_takes_compounding_back(numbers, entries):
    # Given a pose with its covariance, and a step with its own in the frame of the pose
    start, step = np.array(numbers[:3]), np.array(numbers[3:])
    root = np.reshape(entries, (3, 3))
    before, added = root @ root.T + 0.1 * np.eye(3), np.diag((0.03, 0.02, 0.01))
    # When both are compounded (Smith, Self and Cheeseman 1990, by central differences)
    now, d = se2.compose(start, step), 1e-6
    by_start, by_step = np.empty((3, 3)), np.empty((3, 3))
    for i, e in enumerate(d * np.eye(3)):
        by_start[:, i] = (se2.compose(start + e, step) - se2.compose(start - e, step)) / (2 * d)
        by_step[:, i] = (se2.compose(start, step + e) - se2.compose(start, step - e)) / (2 * d)
    by_start[2, 2] = by_step[2, 2] = 1.0  # but for the turn's wrap
    covariance = by_start @ before @ by_start.T + by_step @ added @ by_step.T
    # Then the growth is the step's
    assert growth(start, before, now, covariance) == pytest.approx(added, abs=1e-5)


def test_odometry_that_tells_its_covariance_replaces_the_parameters():
    motion = Motion(np.zeros(3), 0.0, np.zeros((3, 3)))
    motion.deviations += 0.5  # as after a pose that was given
    for k in range(1, 11):
        told = k / 10.0 * np.diag((0.03**2, 0.04**2, 0.01**2))
        motion.add(np.array((0.1 * k, 0.0, 0.0)), SlamParameters(), told)
    assert motion.deviations == pytest.approx(0.5 + np.array((0.03, 0.04, 0.01)) + TOLD_MIN)


def test_where_no_covariance_is_told_the_parameters_count():
    told, untold = Motion(np.zeros(3), 0.0, np.eye(3)), Motion(np.zeros(3), 0.0)
    for motion in (told, untold):
        motion.add(np.array((0.3, 0.1, 0.2)), SlamParameters())
    assert told.deviations == pytest.approx(untold.deviations)
