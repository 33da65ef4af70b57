"""The covariance that odometry piles up, against closed form."""

from __future__ import annotations

import numpy as np
import pytest

from gridslam.odometry.drift import Drift
from gridslam.odometry.matching import ScanMatch

NONE, ALONG_X = np.zeros((0, 2)), np.array(((1.0, 0.0),))


def keyframe(newness: float, untold: np.ndarray = NONE) -> ScanMatch:
    return ScanMatch(np.zeros(3), np.eye(3), untold, 1.0, newness)


def test_an_error_of_the_heading_becomes_one_of_the_place():
    drift = Drift()
    drift.on_keyframe(keyframe(1.0), np.diag((0.0, 0.0, 0.01**2)))
    drift.on_move(np.array((3.0, 0.0)))
    drift.on_move(np.array((0.0, 4.0)))
    assert np.sqrt(np.diag(drift.covariance)) == pytest.approx((0.04, 0.03, 0.01))


def test_a_keyframe_moves_the_mean_of_m_keyframes_by_one_mth_of_its_error():
    drift = Drift()
    for _ in range(9):
        drift.on_keyframe(keyframe(1.0 / 6.0), np.diag((0.02**2, 0.04**2, 0.002**2)))
    assert np.sqrt(np.diag(drift.covariance)) == pytest.approx((0.01, 0.02, 0.001))


def test_what_was_not_told_counts_when_it_is_told_again():
    drift, before, after = Drift(), np.diag((0.5, 0.1, 0.1)), np.diag((0.1, 0.1, 0.1))
    drift.on_keyframe(keyframe(1.0, ALONG_X), before)
    assert drift.covariance[0, 0] == 0.0
    drift.on_match(ALONG_X, before, after)
    assert drift.covariance[0, 0] == pytest.approx(0.4)
    drift.on_match(NONE, before, after)
    assert drift.covariance[0, 0] == pytest.approx(0.4)
