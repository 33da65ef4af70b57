"""Places that enough passes have mapped, and the poses there that no scan is kept for."""

import numpy as np
import pytest

from gridslam.filter.kept.known_places import PASSES_ENOUGH, adds_nothing, known_node
from gridslam.filter.kept.light_poses import LightPose, LightPoses
from gridslam.maps.beams import Beams
from gridslam.maps.new_map import ALL_HEIGHTS
from gridslam.maps.newest_scans import NewestScans, placed
from gridslam.scan import PlanarScan
from gridslam.tracking.evidence import Agreement
from gridslam.trajectory import Trajectory

HERE = np.array((5.0, 0.1, 0.0))


def passes(count):
    """So many passes of a corridor of 10 m in one direction, a node each metre; the way back is 3 m aside."""
    there = np.column_stack([np.arange(11.0), np.zeros((11, 2))])
    back = np.column_stack([np.arange(10.0, -1.0, -1.0), np.full(11, 3.0), np.full(11, np.pi)])
    return np.concatenate([there, back] * count)


def asked(path, pose=HERE, height_m=np.nan, heights_m=np.nan, usable=True):
    k = len(path)
    return known_node(path, np.full(k, heights_m), np.full(k, usable), pose, height_m)


def test_a_place_is_known_after_enough_passes():
    assert asked(passes(PASSES_ENOUGH - 1)) is None
    assert asked(passes(PASSES_ENOUGH)) == 5  # the first of those that are equally near


def test_many_nodes_of_one_pass_are_no_passes():
    turning = np.column_stack([np.full(50, 5.0), np.zeros(50), np.linspace(-0.4, 0.4, 50)])
    assert asked(turning) is None


@pytest.mark.table("pose", [(5.0, 0.6, 0.0), (5.0, 0.1, 0.6), (5.0, 0.1, np.pi)])
def test_another_place_or_heading_is_not_known(pose):
    assert asked(passes(PASSES_ENOUGH), np.array(pose)) is None


def test_another_height_or_map_is_not_known():
    path = passes(PASSES_ENOUGH)
    assert asked(path, height_m=1.2, heights_m=1.0) == 5
    assert asked(path, height_m=1.3, heights_m=1.0) is None
    assert asked(path, usable=False) is None


def beams_at(normals):
    matching = np.zeros((len(normals), 7))
    matching[:, 4:6] = normals
    return Beams(np.zeros(2), np.zeros((0, 2)), np.zeros(0, bool), matching)


def test_only_a_scan_that_agrees_and_tells_its_pose_adds_nothing():
    corner, wall = beams_at([(1.0, 0.0)] * 50 + [(0.0, 1.0)] * 50), beams_at([(0.0, 1.0)] * 100)
    assert adds_nothing(Agreement(95, 2, 3), corner)
    assert not adds_nothing(Agreement(95, 2, 3), wall)
    assert not adds_nothing(Agreement(85, 0, 15), corner)  # it sees what is new
    assert not adds_nothing(Agreement(85, 15, 0), corner)
    assert not adds_nothing(Agreement(95, 2, 3), beams_at(np.zeros((0, 2))))


def test_light_poses_stand_between_the_nodes_and_move_with_their_anchor():
    light = LightPoses()
    light.add(LightPose(1.5, 2, 0, 0.0, 1.0, 0.5, 0.1))
    light.add(LightPose(2.5, 3, 1, 1.0, 0.0, 0.0, np.nan))
    turned = np.array([(0.0, 0.0, np.pi / 2), (5.0, 0.0, 0.0), (9.0, 0.0, 0.0)])
    path = light.merged(Trajectory(np.arange(3.0), turned, np.array((1.0, 2.0, 3.0))))
    np.testing.assert_array_equal(path.stamps_s, [0.0, 1.0, 1.5, 2.0, 2.5])
    np.testing.assert_allclose(path.poses_in_map[2], (-1.0, 0.0, np.pi / 2 + 0.5), atol=1e-12)
    np.testing.assert_allclose(path.poses_in_map[4], (6.0, 0.0, 0.0))
    np.testing.assert_allclose(path.heights_m, [1.0, 2.0, 1.1, 3.0, np.nan])
    # and the newest of all is where the vehicle was last
    np.testing.assert_allclose(light.now(turned), (6.0, 0.0, 0.0))
    np.testing.assert_allclose(light.now(np.vstack([turned, HERE])), HERE)


@pytest.mark.table("row", [(1.0, 2, 2, 0, 0, 0, 0), (1.0, 4, 0, 0, 0, 0, 0), (np.nan, 2, 0, 0, 0, 0, 0)])
def test_light_poses_that_make_no_sense_are_refused(row):
    with pytest.raises(ValueError, match="known places"):
        LightPoses().restore(np.array([row], float), 3)


def newest(places):
    """Scans of a lidar with one beam, at nodes' places, one after the other; the range tells which it is."""
    scans = NewestScans()
    for index, place in enumerate(places):
        scan = PlanarScan(float(index), np.zeros(1), np.array([1.0 + index]), (0.0, 0.0, 0.0), 50.0)
        scans.add(place, np.array((0.1, 0.0, 0.0)), scan)
    return scans


def ranges_in_map(scans, path, usable, band=ALL_HEIGHTS):
    """Return x of the lidar and the range of each scan that enters a map, m."""
    poses, entered = placed(scans.all(), path, np.array(usable), band)
    return sorted((float(x), float(each.ranges_m[0])) for (x, _, _), each in zip(poses, entered))


def test_the_newest_scans_of_a_place_enter_a_map_thrice_and_move_with_it():
    path = np.array([(0.0, 0.0, 0.0), (5.0, 0.0, 0.0)])
    few = ranges_in_map(newest([1, 0, 1]), path, [True, True])
    np.testing.assert_allclose(few, np.repeat([(0.1, 2.0), (5.1, 1.0), (5.1, 3.0)], 3, axis=0))
    # of 20 scans the last three are there
    many = newest([1] * 20)
    expected = np.repeat([(5.1, 18.0), (5.1, 19.0), (5.1, 20.0)], 3, axis=0)
    np.testing.assert_allclose(ranges_in_map(many, path, [True, True]), expected)
    # and none of a place that is not in the map
    assert ranges_in_map(many, path, [True, False]) == []
    assert ranges_in_map(many, path[:1], [True]) == []


def test_the_newest_scans_are_saved_whole_or_refused():
    scans, again = newest([0, 1, 1]), NewestScans()
    again.restore(scans.all(), 2)
    assert again.all() == scans.all()
    with pytest.raises(ValueError, match="newest scans"):
        again.restore(scans.all(), 1)
