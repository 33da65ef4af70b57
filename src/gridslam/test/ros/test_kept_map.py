"""The copy of slam_octomap's map on disk: which one counts, what is swept away, what cannot be written."""

import os

import pytest

from gridslam.errors import StateError
from gridslam.volume import CorrectedMap, VolumeParameters
from gridslam.volume.path_poses import OdometryHistory
from gridslam.volume.saved.map_time import MapTime
from gridslam.volume.saved.saved_map import state_of

kept_map = pytest.importorskip(
    "gridslam_ros.volume.kept_map", reason="the workspace is not built, or not sourced"
)

STATE = state_of(CorrectedMap(VolumeParameters()), OdometryHistory(), MapTime())
kept_parameter = pytest.importorskip("node_tools.restarts.kept_parameter")
NOBODY = 4_194_305
"""No process: greater than Linux's greatest number."""


@pytest.fixture
def home(tmp_path, monkeypatch):
    """ROS's home, with a parameter server of its own."""
    kept = {}
    monkeypatch.setenv("ROS_HOME", str(tmp_path))
    monkeypatch.setattr(kept_map.rospy, "get_name", lambda: "/slam_octomap")
    monkeypatch.setattr(kept_map.rospy, "get_param", lambda name, default=None: kept.get(name, default))
    monkeypatch.setattr(kept_map.rospy, "set_param", kept.__setitem__)
    monkeypatch.setattr(kept_parameter, "launch_of_this_process", lambda: "this one")
    return tmp_path


def test_a_node_that_starts_again_finds_its_copy_and_a_new_launch_does_not(home, monkeypatch):
    first = kept_map.KeptMap(1.0)
    assert first.found == ""
    first.keep(5.0, STATE)
    again = kept_map.KeptMap(1.0).found
    assert again == str(home / f"slam_octomap_{os.getppid()}.volume")
    assert kept_map.KeptMap(0.0).found == ""
    # When another roslaunch gets the same number, as in another container, then it is another launch
    monkeypatch.setattr(kept_parameter, "launch_of_this_process", lambda: "another one")
    assert kept_map.KeptMap(1.0).found == ""


def test_copies_of_launches_that_are_over_are_swept_away_and_foreign_files_stay(home):
    old = home / f"slam_octomap_{NOBODY}.volume"
    foreign = home / "slam_octomap_2_of_mine.volume"
    ours = home / f"slam_octomap_{os.getpid()}.volume"
    for path in (old, foreign, ours):
        path.write_text("")
    kept_map.KeptMap(1.0)
    assert not old.exists()
    assert foreign.exists()
    assert ours.exists()


def test_a_home_that_cannot_be_written_is_one_sentence(home, monkeypatch):
    in_the_way = home / "file"
    in_the_way.write_text("")
    monkeypatch.setenv("ROS_HOME", str(in_the_way))
    kept = kept_map.KeptMap(1.0)
    with pytest.raises(StateError, match="file"):
        kept.keep(5.0, STATE)
    assert kept.is_due(7.0)


def test_it_is_due_by_its_period_and_after_the_clock_jumped_back(home, monkeypatch):
    monkeypatch.setattr(kept_map.time, "monotonic", lambda: 0.0)
    kept = kept_map.KeptMap(2.0)
    kept.keep(10.0, STATE)
    assert [kept.is_due(now_s) for now_s in (11.0, 12.5, 3.0)] == [False, True, True]


def test_copies_that_take_long_come_seldom(home, monkeypatch):
    wall_s = iter((0.0, 0.2, 0.2, 5.0, 10.3))  # a copy takes 0.2 s
    monkeypatch.setattr(kept_map.time, "monotonic", lambda: next(wall_s))
    kept = kept_map.KeptMap(2.0)
    kept.keep(10.0, STATE)
    assert not kept.is_due(15.0)
    assert kept.is_due(20.0)
