"""The monitor of the pose: states, hysteresis, and that a saved one goes on."""

import dataclasses

import pytest

from gridslam.tracking.evidence import Agreement, Evidence
from gridslam.tracking.monitor import DRIFTING, LOST, TRACKING, UNCERTAIN, MonitorState, TrackingMonitor


def scan(share=1.0, unseen=0, beams=100, spread_m=0.0):
    """The evidence of a scan with this share of agreeing beams among those that are not in unseen space."""
    compared = beams - unseen
    agreement = Agreement(round(share * compared), compared - round(share * compared), unseen)
    return Evidence(0.0, agreement, spread_m, typical_range_m=2.0, travelled_m=0.5)


def states(monitor, *shares):
    return [(monitor.accepts(scan(share)), monitor.state)[1] for share in shares]


def test_the_share_counts_beams_in_unseen_space_only_by_their_weight():
    agreement = Agreement(30, 10, 40)
    assert agreement.share() == 30 / 40
    assert agreement.share(0.5) == 30 / 60
    assert agreement.compared_share == 40 / 80
    assert Agreement(0, 0, 50).share() == 1.0


def test_scans_that_agree_are_tracking():
    assert states(TrackingMonitor(), 1.0, 0.7, 0.9) == [TRACKING] * 3


def test_three_contradictions_in_a_row_are_lost():
    monitor = TrackingMonitor()
    assert states(monitor, 1.0, 0.2, 0.3, 0.2) == [TRACKING, UNCERTAIN, UNCERTAIN, LOST]
    assert monitor.scans_since_tracking == 3
    assert monitor.travelled_since_tracking_m == 1.5
    assert "3 scans in a row contradict the map" in monitor.reason


def test_one_odd_scan_is_refused_and_forgotten():
    monitor = TrackingMonitor()
    assert [monitor.accepts(scan(share)) for share in (1.0, 0.3, 1.0)] == [True, False, True]
    assert states(monitor, 1.0, 1.0) == [TRACKING, TRACKING]


def test_after_a_contradiction_more_must_agree():
    monitor = TrackingMonitor()
    assert monitor.accepts(scan(0.47))
    assert not monitor.accepts(scan(0.4))
    assert not monitor.accepts(scan(0.47))
    assert monitor.accepts(scan(0.55))


def test_many_scans_that_agree_badly_are_lost_in_the_end():
    monitor = TrackingMonitor()
    found = states(monitor, *[0.47] * 12)
    assert found[0] == TRACKING
    assert found[-1] == LOST
    assert found.index(UNCERTAIN) < found.index(LOST)


def test_a_scan_in_unseen_space_says_nothing_while_mapping():
    monitor = TrackingMonitor()
    assert all(monitor.accepts(scan(0.0, unseen=80)) for _ in range(5))
    assert monitor.state == TRACKING


def test_a_scan_in_unseen_space_contradicts_a_known_map():
    monitor = TrackingMonitor(known_map=True)
    for _ in range(3):
        monitor.accepts(scan(0.0, unseen=80))
    assert monitor.state == LOST


def test_particles_far_apart_are_uncertain_by_the_range_of_the_scan():
    monitor = TrackingMonitor()
    spreads = (1.4, 1.6, 1.4, 0.9)  # of 2 m: uncertain above 1.5 m, tracking again below 1 m
    found = []
    for spread_m in spreads:
        monitor.accepts(scan(spread_m=spread_m))
        found.append(monitor.state)
    assert found == [TRACKING, UNCERTAIN, UNCERTAIN, TRACKING]


def test_a_given_pose_is_uncertain_until_it_is_confirmed():
    monitor = TrackingMonitor()
    monitor.doubt("given")
    assert states(monitor, 0.9, 0.9) == [UNCERTAIN, UNCERTAIN]
    assert monitor.agreed == 2
    monitor.confirm()
    assert monitor.state == TRACKING


def test_after_scans_were_missing_the_pose_is_uncertain_until_scans_agree():
    monitor = TrackingMonitor()
    monitor.accepts(scan())
    monitor.bridge("7.0 s before this scan are missing")
    assert (monitor.state, monitor.reason) == (UNCERTAIN, "7.0 s before this scan are missing")
    assert states(monitor, 0.9, 0.9, 0.9) == [UNCERTAIN, TRACKING, TRACKING]


def test_a_map_that_goes_on_in_unseen_space_after_a_gap_may_be_displaced_until_a_place_is_recognised():
    monitor = TrackingMonitor()
    monitor.bridge("7.0 s before this scan are missing")
    # scans in unseen space are mapped, and confirm nothing
    assert all(monitor.accepts(scan(0.0, unseen=80)) for _ in range(5))
    assert monitor.state == UNCERTAIN
    # those that agree with what was mapped since do not tell where it lies
    assert states(monitor, 0.9, 0.9, 0.9) == [UNCERTAIN, DRIFTING, DRIFTING]
    assert "scans were missing" in monitor.reason
    monitor.check(monitor.self_check.recognised())
    assert monitor.state == TRACKING


def test_after_scans_were_missing_scans_may_contradict_the_map_all_the_same():
    monitor = TrackingMonitor()
    monitor.bridge("7.0 s before this scan are missing")
    assert states(monitor, 0.2, 0.2, 0.2) == [UNCERTAIN, UNCERTAIN, LOST]


def test_apart_from_an_earlier_map_no_scan_makes_the_pose_tracked():
    monitor = TrackingMonitor()
    states(monitor, 0.2, 0.2, 0.2)
    monitor.begin_apart("not found")
    assert states(monitor, 1.0, 1.0, 1.0) == [UNCERTAIN] * 3
    monitor.doubt("odometry has jumped")
    monitor.confirm()
    assert states(monitor, 1.0) == [UNCERTAIN]
    monitor.join()
    assert states(monitor, 1.0) == [TRACKING]


def test_a_saved_monitor_goes_on():
    monitor, again = TrackingMonitor(), TrackingMonitor()
    states(monitor, 1.0, 0.3, 0.4)
    again.restore(monitor.state_to_save())
    assert again.state_to_save() == monitor.state_to_save()
    assert states(again, 0.3) == [LOST]


@pytest.mark.table(
    ("name", "value"),
    [("state", "happy"), ("agreed", -1), ("contradictions", 0.5), ("smoothed_share", 7.0)],
)
def test_a_saved_monitor_that_makes_no_sense_is_refused(name, value):
    state = TrackingMonitor().state_to_save()
    with pytest.raises(ValueError, match="tracking"):
        MonitorState(**{**dataclasses.asdict(state), name: value})
