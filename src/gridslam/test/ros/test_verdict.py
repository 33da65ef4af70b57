"""What a replay says of its own map."""

import pytest

pytest.importorskip("rosbag", reason="needs ROS")
verdicts = pytest.importorskip("gridslam_ros.verdict")
Verdict, LoosePartsWatch = verdicts.Verdict, verdicts.LoosePartsWatch


def verdict(**states):
    found = Verdict()
    for state, count in states.items():
        for _ in range(count):
            found.add(state)
    return found


def test_a_tracked_run_of_one_map_says_nothing():
    assert verdict(tracking=8).sentences([], 100.0) == []
    assert Verdict().sentences([], 100.0) == []


def test_the_shares_of_the_states_are_told():
    found = verdict(tracking=5, uncertain=2, lost=1)
    assert found.shares == {"tracking": 0.625, "drifting": 0.0, "uncertain": 0.25, "lost": 0.125}
    (sentence,) = found.sentences([], 100.0)
    assert "62.5% tracking, 25.0% uncertain, 12.5% lost" in sentence


def test_parts_that_odometry_alone_joins_are_counted_from_the_first_scan():
    (sentence,) = verdict(tracking=1).sentences([112.5, 140.0], 100.0)
    assert "The map has 3 parts" in sentence
    assert "at 12.5 s, 40.0 s after the first scan" in sentence
    (sentence,) = verdict(tracking=1).sentences([100.0 + k for k in range(1, 9)], 100.0)
    assert "5.0 s and 3 more after the first scan" in sentence


def test_the_node_tells_of_loose_parts_when_their_number_changes():
    watch = LoosePartsWatch()
    # parts begin at these stamps, and the first scan at 100 s
    said = [watch.follow(parts_s, lambda: [100.0, 101.0]) for parts_s in ([], [112.5], [112.5], [])]
    assert said[0] == said[2] == ""
    assert "The map has 2 parts" in said[1]
    assert "at 12.5 s after the first scan" in said[1]
    assert said[3] == "Scans or closures join all parts of the map now."
