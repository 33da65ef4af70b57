"""A map that followed its path, against one made afresh with the same poses, and against OctoMap."""

from __future__ import annotations

import numpy as np
import pytest
from flown_volumes import PARAMETERS, assert_equal, cloud_at, flown, fresh
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_volume import body_of

from gridslam import ScanError
from gridslam.volume import (
    Board,
    Box,
    CorrectedMap,
    NodeSpacing,
    Pose,
    Rebuilding,
    VoxelMap,
    stream_of,
)
from gridslam.volume.correction.events import insert_event

small = st.floats(-0.6, 0.6)
places = st.lists(
    st.tuples(st.floats(3.0, 27.0), st.floats(3.0, 17.0), st.floats(1.0, 9.0), st.floats(-3.1, 3.1)),
    min_size=3,
    max_size=7,
)
shifts = st.lists(st.one_of(st.just((0.0, 0.0, 0.0)), st.tuples(small, small, small)), min_size=7, max_size=7)


@settings(max_examples=15)
@given(places, shifts)
def test_a_rebuilt_map_equals_a_fresh_one_and_octomaps(path, moves):
    corrected = flown(path)
    poses = [
        Pose.level(move[0], move[1], 0.1 * move[2]) @ node.sensor_in_map
        for move, node in zip(moves, corrected.nodes)
    ]
    rebuilding = Rebuilding(corrected, poses)
    expected = [
        pose if moves else node.sensor_in_map
        for moves, pose, node in zip(corrected.moved(poses), poses, corrected.nodes)
    ]
    rebuilding.take_over()
    assert [node.sensor_in_map for node in corrected.nodes] == expected
    assert_equal(corrected.voxels, fresh(corrected))
    octomap = pytest.importorskip("pyoctomap")
    tree = octomap.OcTree(PARAMETERS.resolution_m)
    for node in corrected.nodes:
        origin = node.sensor_in_map.translation.astype(np.float32).astype(float)
        tree.insertPointCloud(node.sensor_in_map.of_points(node.cloud.points()).astype(float), origin)
    assert stream_of(corrected.voxels, is_binary=False).data == body_of(tree.write())


PATH = [(5.0 + k, 5.0 + 0.5 * k, 3.0, 0.1 * k) for k in range(8)]


def turned(corrected, first=0):
    """Poses after a correction of the nodes from one on."""
    correction = Pose.level(0.4, -0.3, 0.05)
    return [
        correction @ node.sensor_in_map if number >= first else node.sensor_in_map
        for number, node in enumerate(corrected.nodes)
    ]


def test_clouds_and_cleared_boxes_during_a_rebuild_are_in_the_map():
    corrected = flown(PATH)
    before = corrected.voxels.values(corrected.voxels.box())
    rebuilding = Rebuilding(corrected, turned(corrected, 4))
    for _ in range(5):
        rebuilding.step()
    np.testing.assert_array_equal(corrected.voxels.values(corrected.voxels.box()), before)  # still in service
    points, pose = cloud_at(14.0, 9.0, 4.0, 1.0, seed=20)
    corrected.add(20.0, points, pose, Pose.level(0.4, -0.3, 0.05))
    corrected.clear(Box(np.array((0, 0, 0)), np.array((40, 10, 20))))
    corrected.add(21.0, points, pose, Pose.level(0.4, -0.3, 0.05))
    rebuilding.take_over()
    voxels = VoxelMap(PARAMETERS)
    for event in corrected.events:
        insert_event(voxels, event, None, Board())
    assert len(corrected.events) == len(PATH) + 3
    assert_equal(corrected.voxels, voxels)


def test_a_second_correction_begins_at_the_poses_of_the_first():
    corrected = flown(PATH)
    Rebuilding(corrected, turned(corrected)).take_over()
    Rebuilding(corrected, turned(corrected, 3)).take_over()
    assert_equal(corrected.voxels, fresh(corrected))


@pytest.mark.table("first", [0, 2, 5, 7])
def test_corrections_of_the_latest_nodes_begin_behind_settled_ones(first, monkeypatch):
    """Given a map whose oldest events are settled, when later or older nodes move, it is as made afresh."""
    monkeypatch.setattr("gridslam.volume.correction.rebuilding.UNSETTLED", (5, 3))
    corrected = flown(PATH, base=flown([(15.0, 10.0, 5.0, 0.3)]).voxels)
    corrected.clear(Box(np.array((0, 0, 0)), np.array((20, 10, 20))))
    for start in (6, first):
        rebuilding = Rebuilding(corrected, turned(corrected, start))
        entered = rebuilding.progress[0]
        rebuilding.take_over()
        rebuilding.settle()
        voxels = corrected.base.copy()
        for event in corrected.events:
            insert_event(voxels, event, None, Board())
        assert_equal(corrected.voxels, voxels)
        assert [each.count for each in corrected.settled] == [len(PATH) + 1 - 5, len(PATH) + 1 - 3]
    assert entered == {7: 6, 5: 4}.get(first, 0)


def test_events_are_settled_in_flight_so_that_a_first_closure_begins_behind_them(monkeypatch):
    monkeypatch.setattr("gridslam.volume.correction.rebuilding.UNSETTLED", (5, 3))
    corrected = flown(PATH)
    unmoved = Rebuilding(corrected, [node.sensor_in_map for node in corrected.nodes])
    unmoved.settle(iter((True, True, False)).__next__)
    assert [each.count for each in corrected.settled] == [2]  # it was asked to leave off
    unmoved.settle()
    rebuilding = Rebuilding(corrected, turned(corrected, 4))
    assert rebuilding.progress[0] == 3
    rebuilding.take_over()
    assert_equal(corrected.voxels, fresh(corrected))


def test_an_earlier_map_stays_below_the_path():
    corrected = flown(PATH, base=flown([(15.0, 10.0, 5.0, 0.3)]).voxels)
    Rebuilding(corrected, turned(corrected)).take_over()
    assert_equal(corrected.voxels, fresh(corrected))


def test_a_correction_below_half_a_voxel_moves_nothing():
    corrected = flown(PATH)
    poses = [Pose.level(0.05, 0.05, 0.0) @ node.sensor_in_map for node in corrected.nodes]
    rebuilding = Rebuilding(corrected, poses)
    assert (rebuilding.moved, rebuilding.is_due) == (0, False)
    stamp = corrected.voxels.stamp
    rebuilding.take_over()
    assert corrected.voxels.stamp == stamp


def test_only_tiles_that_differ_are_told_after_a_correction():
    corrected = flown([*PATH, (25.0, 15.0, 7.0, 0.0)])
    old, stamp = corrected.voxels.copy(), corrected.voxels.stamp
    Rebuilding(corrected, turned(corrected, 8)).take_over()
    voxels, differs = corrected.voxels, 0
    for place in voxels.known_places():
        low = (place[::-1] + voxels.corner) * 16
        before, after = (each.values(Box(low, low + 16)) for each in (old, voxels))
        has_changed = not np.array_equal(before, after, equal_nan=True)
        assert (voxels.pool.tiles.written[voxels.table[tuple(place)]] > stamp) == has_changed
        differs += has_changed
    assert 0 < differs < len(voxels.known_places())


def test_a_node_comes_with_way_turn_or_time():
    spacing = NodeSpacing()
    corrected = CorrectedMap(PARAMETERS, spacing)
    points = cloud_at(15.0, 10.0, 5.0, 0.0)[0]
    steps = [
        (0.0, 0.0, 0.0),
        (0.1, 0.24, 0.0),
        (0.2, 0.25, 0.0),
        (0.3, 0.25, 4.9),
        (0.4, 0.25, 5.1),
        (1.39, 0.25, 5.1),
        (1.41, 0.25, 5.1),
    ]
    kept = [
        corrected.add(stamp, points, Pose.level(15.0 + x, 10.0, np.radians(angle)), Pose.identity())
        for stamp, x, angle in steps
    ]
    assert kept == [True, False, True, False, True, False, True]


def test_a_kept_cloud_has_one_point_a_voxel_and_all_voxels_of_the_cloud():
    points, pose = cloud_at(15.0, 10.0, 5.0, 0.4)
    corrected = CorrectedMap(PARAMETERS)
    corrected.add(0.0, points, pose, Pose.identity())
    kept = corrected.nodes[0].cloud.points()
    voxels_of = [np.floor(pose.of_points(each) / 0.4).astype(int) for each in (kept, points)]
    assert len(np.unique(voxels_of[0], axis=0)) == len(kept) < len(points)
    assert np.abs(kept[:, None] - points[None, :]).max(axis=2).min(axis=1).max() <= 0.4 / 64 + 1e-5


def test_clouds_that_cannot_be_used_are_told_and_the_map_stays():
    corrected = flown(PATH[:1])
    before = corrected.voxels.values(corrected.voxels.box())
    with pytest.raises(ScanError, match="no point"):
        corrected.add(1.0, np.full((5, 3), np.nan), Pose.identity(), Pose.identity())
    with pytest.raises(ScanError, match="no point"):
        corrected.add(1.0, np.zeros((0, 3)), Pose.identity(), Pose.identity())
    with pytest.raises(ScanError, match="too large"):
        corrected.add(1.0, np.zeros((10_000_000, 3), np.float32), Pose.identity(), Pose.identity())
    np.testing.assert_array_equal(corrected.voxels.values(corrected.voxels.box()), before)


def test_a_map_that_begins_anew_is_empty():
    corrected = flown(PATH[:2])
    rebuilding = Rebuilding(corrected, turned(corrected))
    corrected.reset()
    rebuilding.take_over()
    assert isinstance(corrected.voxels, VoxelMap)
    assert (corrected.voxels.pool.used, corrected.nodes) == (0, [])
