"""A map that was saved and goes on, against one that was never interrupted."""

from __future__ import annotations

import numpy as np
import pytest
from flown_volumes import EVERY, PARAMETERS, assert_equal, cloud_at, fresh

from gridslam import StateError
from gridslam.files import state_file
from gridslam.volume import Box, CorrectedMap, NodeSpacing, Pose, Rebuilding, ShownMap
from gridslam.volume.path_poses import OdometryHistory, odom_in_map
from gridslam.volume.saved.map_time import MapTime
from gridslam.volume.saved.saved_map import read_volume, state_of, write_volume

WAY = [(6.0 + 2.0 * number, 8.0, 3.0, 0.2 * number) for number in range(6)]


def add(corrected, history, map_time, stamp_s, place, odom_in_map=None):
    """A cloud at a place in odom, with the odometry's pose."""
    time_s = map_time.of_cloud(stamp_s)
    points, pose = cloud_at(*place, seed=round(1e3 * place[0]))
    history.add(time_s, pose)
    corrected.add(time_s, points, pose, odom_in_map or Pose.identity())


def flown(places, first_s=0.0):
    corrected, history, map_time = CorrectedMap(PARAMETERS, EVERY), OdometryHistory(), MapTime()
    for number, place in enumerate(places):
        add(corrected, history, map_time, first_s + number, place)
    return corrected, history, map_time


def test_a_saved_map_goes_on_as_one_that_was_never_interrupted(tmp_path):
    saved = flown(WAY[:3])
    saved[0].clear(Box(np.array((10, 10, 2)), np.array((20, 20, 10))))
    whole, whole_history, whole_time = flown(WAY[:3])
    whole.clear(Box(np.array((10, 10, 2)), np.array((20, 20, 10))))
    write_volume(state_of(*saved), tmp_path / "map.volume")
    going_on = read_volume(tmp_path / "map.volume")
    for number, place in enumerate(WAY[3:], start=3):
        add(*going_on, float(number), place)
        add(whole, whole_history, whole_time, float(number), place)
    assert_equal(going_on.corrected.voxels, whole.voxels)
    assert len(going_on.corrected.nodes) == len(WAY)


def test_a_loop_moves_the_nodes_of_the_flight_before_too(tmp_path):
    write_volume(state_of(*flown(WAY[:3], first_s=50.0)), tmp_path / "map.volume")
    corrected, history, map_time = read_volume(tmp_path / "map.volume")
    for number, place in enumerate(WAY[3:]):
        add(corrected, history, map_time, 7.0 + number, place)  # the clock began anew
    stamps_s = np.array((50.0, 51.0, 52.0, 7.0, 8.0, 9.0))
    path = np.array([(x + 0.5, y - 0.5, yaw) for x, y, _, yaw in WAY])
    are_known, times_s, _ = map_time.of_path(stamps_s)
    node_times_s = np.array([node.stamp_s for node in corrected.nodes])
    in_map = odom_in_map(times_s, path[are_known], history, node_times_s)
    poses = [odom @ node.sensor_in_odom for odom, node in zip(in_map, corrected.nodes)]
    rebuilding = Rebuilding(corrected, poses)
    assert rebuilding.moved == len(WAY)
    rebuilding.take_over()
    for node, (x, y, _, _) in zip(corrected.nodes, WAY):
        np.testing.assert_allclose(node.sensor_in_map.translation[:2], (x + 0.5, y - 0.5), atol=1e-6)
    assert_equal(corrected.voxels, fresh(corrected))


def test_an_earlier_map_stays_below_a_saved_one(tmp_path):
    base = flown(WAY[:2])[0].voxels
    corrected = CorrectedMap(PARAMETERS, EVERY, base)
    points, pose = cloud_at(*WAY[4])
    corrected.add(0.0, points, pose, Pose.identity())
    write_volume(state_of(corrected, OdometryHistory(), MapTime()), tmp_path / "map.volume")
    restored = read_volume(tmp_path / "map.volume").corrected
    assert_equal(restored.voxels, corrected.voxels)
    assert restored.base is not None
    assert_equal(restored.base, base)


def test_a_path_of_a_slam_that_began_anew_leaves_the_flight_before_where_it_is():
    map_time = MapTime(newest_s=60.0)
    assert map_time.of_cloud(2.0) == 61.0
    are_known, times_s, since_s = map_time.of_path(np.array((2.0, 3.0)))
    assert are_known.all()
    np.testing.assert_allclose(times_s, (61.0, 62.0))
    assert since_s == 61.0


def test_a_node_that_died_in_flight_goes_on_in_the_same_flight():
    map_time = MapTime(newest_s=60.0)
    assert map_time.of_cloud(61.5) == 61.5
    assert len(map_time.flights) == 1


def test_poses_of_flights_before_the_map_do_not_count():
    map_time = MapTime()
    map_time.of_cloud(1.0)
    are_known, times_s, _ = map_time.of_path(np.array((5.0, 6.0, 0.5, 1.5)))
    assert are_known.tolist() == [False, False, True, True]
    np.testing.assert_allclose(times_s, (0.5, 1.5))


@pytest.mark.table("damage", ["cut", "foreign", "cloud", "none"])
def test_a_file_that_cannot_be_used_gets_one_sentence(tmp_path, damage):
    path = tmp_path / "map.volume"
    state = state_of(*flown(WAY[:2]))
    if damage == "cloud":
        object.__setattr__(state.events[0], "packed", np.zeros(100, np.uint8))
    if damage == "foreign":
        state_file.write(NodeSpacing(), path)
    elif damage != "none":
        write_volume(state, path)
    if damage == "cut":
        path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(StateError, match=r"map\.volume") as told:
        read_volume(path)
    assert str(told.value).count("\n") == 0


def test_the_map_that_takes_over_a_state_is_shown_anew():
    corrected, other = flown(WAY[:2])[0], flown(WAY[3:])[0]
    shown = ShownMap(PARAMETERS.resolution_m)
    shown.refresh(corrected)
    corrected.take_over(other)
    shown.refresh(corrected)
    wanted = ShownMap(PARAMETERS.resolution_m)
    wanted.refresh(CorrectedMap(PARAMETERS, EVERY, other.voxels))
    assert shown.octree().data == wanted.octree().data


def test_the_path_of_another_map_tells_nothing_of_the_clouds_before(tmp_path):
    # given SLAM that begins another map in the same frame after the third cloud
    corrected, history, map_time = flown(WAY[:3], first_s=50.0)
    map_time.begin_map()
    for number, place in enumerate(WAY[3:], start=3):
        add(corrected, history, map_time, 50.0 + number, place)
    are_known, times_s, since_s = map_time.of_path(np.array((53.0, 54.0, 55.0)))
    assert are_known.all()
    np.testing.assert_array_equal(times_s, (53.0, 54.0, 55.0))
    # then its path holds from there on, also after the map was saved
    assert 52.0 < since_s <= 53.0
    write_volume(state_of(corrected, history, map_time), tmp_path / "map.volume")
    assert read_volume(tmp_path / "map.volume").time.of_path(times_s)[2] == since_s
