"""The filter gives snapshots, which stay as they are, and takes corrections."""

import dataclasses

import numpy as np
import pytest
import rooms

from gridslam import StateError, se2
from gridslam.loop_closure.correction import Correction


@pytest.fixture(scope="module")
def log():
    return rooms.log()


def test_a_snapshot_stays_as_it_is_while_the_filter_goes_on(log):
    slam = rooms.begin(log, keep_scans=True)
    rooms.run(slam, log, 0, 60)
    snapshot, path = slam.snapshot(), slam.trajectory()
    before = [snapshot.poses_in_map.copy(), snapshot.odometry.copy(), snapshot.scans, snapshot.in_map]
    rooms.run(slam, log, 60)
    slam.begin_map()
    # then it is the path of then, with the odometry at its scans, and nobody can write into it
    assert len(snapshot) == len(path.stamps_s) < len(slam.trajectory().stamps_s)
    np.testing.assert_array_equal(snapshot.poses_in_map, path.poses_in_map)
    at = np.searchsorted([scan.stamp_s for scan in log.scans], snapshot.stamps_s)
    np.testing.assert_array_equal(snapshot.odometry, np.array(log.odometry)[at])
    np.testing.assert_array_equal(snapshot.poses_in_map, before[0])
    np.testing.assert_array_equal(snapshot.odometry, before[1])
    assert (snapshot.scans, snapshot.in_map) == (before[2], before[3])
    for name in ("stamps_s", "poses_in_map", "odometry", "heights_m", "is_usable"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(snapshot, name)[0] = 0.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        snapshot.first_in_map = 3


def test_parts_of_different_lengths_are_no_snapshot(log):
    slam = rooms.begin(log, keep_scans=True)
    rooms.run(slam, log, 0, 60)
    snapshot = slam.snapshot()
    for name in ("stamps_s", "odometry", "heights_m", "scans", "clouds", "is_usable"):
        with pytest.raises(ValueError, match="one length"):
            dataclasses.replace(snapshot, **{name: getattr(snapshot, name)[:-1]})


def test_a_filter_that_keeps_no_scans_gives_none(log):
    with pytest.raises(StateError, match="keep_scans=True"):
        rooms.begin(log).snapshot()


def test_after_a_correction_of_heights_the_nodes_since_then_rise_with_the_last(log):
    slam = rooms.begin(log, keep_scans=True)
    rooms.run(slam, rooms.at_height(log, 2.0), 0, 60)
    known = len(slam.snapshot())
    rooms.run(slam, rooms.at_height(log, 2.0), 60, 90)
    poses, heights_m = slam.trajectory().poses_in_map[:known], 2.0 + 0.01 * np.arange(known)
    slam.correct(Correction(poses, heights_m=heights_m))
    found = slam.trajectory().heights_m
    np.testing.assert_allclose(found[:known], heights_m)
    np.testing.assert_allclose(found[known:], heights_m[-1])
    assert slam.rise_m == pytest.approx(0.01 * (known - 1))
    rooms.run(slam, rooms.at_height(log, 2.5), 90)
    assert slam.trajectory().heights_m[-1] == pytest.approx(2.5 + slam.rise_m)
    # and what is taken over later counts from there
    slam.correct(Correction(slam.trajectory().poses_in_map, heights_m=slam.trajectory().heights_m + 0.1))
    assert slam.rise_m == pytest.approx(0.01 * (known - 1) + 0.1)


def test_after_a_correction_the_nodes_since_then_follow_as_measured(log):
    slam = rooms.begin(log, keep_scans=True)
    rooms.run(slam, log, 0, 60)
    snapshot = slam.snapshot()
    rooms.run(slam, log, 60, 90)
    path, moved = slam.trajectory().poses_in_map, np.array((2.0, -1.0, 0.3))
    known = len(snapshot)
    assert known < len(path)
    # when the first nodes are turned and shifted, with or without the map that was made of them
    poses = se2.compose(moved, snapshot.poses_in_map)
    since = se2.between(path[known - 1], path[known:])
    expected = np.vstack([poses, se2.compose(poses[-1], since)])
    grids = []
    for draft in (snapshot.map_of(poses, 0), None):
        slam.correct(Correction(poses, 0, draft))
        found = slam.trajectory().poses_in_map
        np.testing.assert_allclose(found, expected, atol=1e-9)
        grids.append(slam.grid().cells)
    np.testing.assert_array_equal(*grids)
