"""The pose's own check: drift that closures tell, ways without a place, and what is left open."""

import numpy as np
import pytest

from gridslam.errors import StateError
from gridslam.tracking.evidence import Agreement, Evidence
from gridslam.tracking.monitor import DRIFTING, LOST, TRACKING, UNCERTAIN, TrackingMonitor
from gridslam.tracking.self_check import SelfCheck, drift_of


def straight(length_m, wrong_from_m, wrong_m):
    """A path along x, a node a metre, with an error to the side that grows from somewhere on; and without."""
    x = np.arange(length_m + 1.0)
    true = np.column_stack([x, np.zeros((len(x), 2))])
    wrong = true.copy()
    wrong[:, 1] = wrong_m * np.clip((x - wrong_from_m) / (length_m - wrong_from_m), 0.0, 1.0)
    return wrong, true


def test_the_correction_of_a_path_tells_how_fast_it_drifted():
    # given errors of 2 m that have grown over 100 m; its first tenth counts as right
    wrong, true = straight(200, 100, 2.0)
    way_m = 90.0 + np.hypot(1.0, 0.02) * 100.0 - 100.0  # along the wrong path
    assert drift_of(wrong, true) == pytest.approx(2.0 / way_m, rel=0.02)
    # an error of less than half a metre tells nothing; one that came at once has grown over 10 m
    assert drift_of(*straight(200, 100, 0.45)) == 0.0
    assert drift_of(*straight(200, 199, 1.0)) == pytest.approx(0.1)


def test_a_drift_that_a_closure_told_goes_on_until_a_place_is_found():
    # given a closure that told a drift of 2 % of the way
    check = SelfCheck().travelled(100.0).recognised(0.02)
    assert (check.drift, check.expected_m, check.is_doubted) == (0.02, 0.0, False)
    # then it is trusted for 25 m, for 0.5 m are 2 % of them, and again after a place is found
    assert not check.travelled(24.9).is_doubted
    doubted = check.travelled(25.1)
    assert doubted.is_doubted
    assert "no place was recognised for 25 m" in doubted.reason
    assert not doubted.recognised().is_doubted
    assert not SelfCheck().travelled(1000.0).is_doubted


def test_a_drift_counts_half_after_50_m_in_which_places_were_right():
    check = SelfCheck(drift=0.04)
    for _ in range(5):
        check = check.travelled(10.0).recognised()
    assert check.drift == pytest.approx(0.02)


def test_what_is_open_is_doubted_until_it_is_decided():
    check = SelfCheck().left_open(0.45)
    assert not check.is_doubted
    check = check.left_open(3.0)
    assert check.is_doubted
    assert "off by 3.0 m" in check.reason
    # with hysteresis: from 0.3 m on
    assert check.left_open(0.4).is_doubted
    assert not check.left_open(0.2).is_doubted


def test_a_spread_is_drift_until_a_place_is_recognised():
    # with hysteresis: from 0.5 m on, until it is less than 0.3 m
    check = SelfCheck().spread_over(0.45, 0.3)
    assert not check.is_drifting
    check = check.spread_over(0.55, 0.3)
    assert (check.is_drifting, check.is_doubted) == (True, False)
    assert check.spread_over(0.4, 0.2).is_drifting
    assert not check.spread_over(0.2, 0.2).is_drifting
    assert "may have drifted by 0.6 m" in check.spread_over(0.6, 0.3).reason_of_drift
    assert "may have drifted by 0.8 m" in check.spread_over(0.6, 0.6).reason_of_drift
    # a place that was recognised is as good as the map there, by the size that errors had so far
    assert not check.spread_over(0.6, 1.4, error_share=0.15).recognised().is_drifting
    displaced = SelfCheck().spread_over(0.0, 1.4, error_share=0.5).recognised()
    assert displaced.is_drifting
    assert "this part of the map is; it may be off by 0.9 m" in displaced.reason_of_drift


def test_in_the_map_one_and_a_quarter_deviations_may_be_wrong():
    assert not SelfCheck().spread_over(0.0, 0.39).is_drifting
    assert SelfCheck().spread_over(0.0, 0.41).is_drifting


def test_all_of_the_maps_spread_counts_where_the_pose_was_seen_to_drift_fast():
    # given a map whose place is known to 0.8 m, and a place that was recognised in it
    usual, slipped = (
        SelfCheck().recognised(drift).spread_over(0.0, 0.8, error_share=0.2) for drift in (0.03, 0.2)
    )
    assert not usual.is_drifting
    assert slipped.is_drifting
    assert "it may be off by 1.0 m" in slipped.reason_of_drift
    # then it counts until the drift is old: half each 50 m
    later = slipped.travelled(50.0).recognised().travelled(50.0).recognised()
    assert later.drift == pytest.approx(0.05)
    assert not later.is_drifting


@pytest.mark.table("value", [-1.0, float("nan"), float("inf")])
def test_numbers_without_sense_are_refused(value):
    with pytest.raises(StateError, match="make no sense"):
        SelfCheck(drift=value)


def agreeing(travelled_m=1.0):
    return Evidence(0.0, Agreement(100, 0, 0), typical_range_m=2.0, travelled_m=travelled_m)


def test_a_pose_that_is_known_to_be_wrong_is_not_tracking_though_all_beams_agree():
    monitor = TrackingMonitor()
    monitor.accepts(agreeing())
    assert monitor.state == TRACKING
    # when a place that was seen before says that the pose is 3 m off
    monitor.check(monitor.self_check.left_open(3.0))
    assert monitor.state == UNCERTAIN
    assert monitor.accepts(agreeing())
    assert (monitor.state, monitor.reason) == (UNCERTAIN, monitor.self_check.reason)
    # then the correction ends the doubt, also for a vehicle that waits
    monitor.check(monitor.self_check.recognised(0.3).left_open(0.0))
    assert monitor.state == TRACKING
    # and the next way without a place is doubted
    for _ in range(3):
        monitor.accepts(agreeing())
    assert monitor.state == UNCERTAIN


def test_a_pose_that_may_have_drifted_is_drifting_though_all_beams_agree():
    monitor = TrackingMonitor()
    monitor.accepts(agreeing())
    # when scans and odometry have let the pose drift by up to 0.8 m, also for a vehicle that waits
    monitor.check(monitor.self_check.spread_over(0.8, 0.8, error_share=0.2))
    assert (monitor.state, monitor.reason) == (DRIFTING, monitor.self_check.reason_of_drift)
    # then its scans are used, and what contradicts the pose counts more
    assert monitor.accepts(agreeing())
    assert (monitor.state, monitor.is_on_the_map) == (DRIFTING, True)
    monitor.check(monitor.self_check.left_open(3.0))
    assert monitor.state == UNCERTAIN
    monitor.check(monitor.self_check.left_open(0.0))
    assert monitor.state == DRIFTING
    # and a place that is recognised ends it
    monitor.check(monitor.self_check.recognised())
    assert monitor.state == TRACKING


def test_other_doubts_are_not_ended_by_it():
    monitor = TrackingMonitor()
    monitor.check(monitor.self_check.left_open(3.0))
    monitor.lose("nothing agrees")
    monitor.check(monitor.self_check.left_open(0.0))
    assert monitor.state == LOST
    monitor.doubt("the pose was given")
    monitor.check(monitor.self_check.left_open(3.0))
    monitor.check(monitor.self_check.left_open(0.0))
    assert (monitor.state, monitor.reason) == (UNCERTAIN, "the pose was given")
