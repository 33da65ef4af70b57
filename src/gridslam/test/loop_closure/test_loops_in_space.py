"""Loops that clouds close, in a room that is flown round at several heights."""

import dataclasses
import functools

import numpy as np
import pytest
from puck_in_a_room import LEVEL, cloud, heading

from gridslam import se2
from gridslam.errors import ScanError
from gridslam.inputs.attitude import matrix_of_lean
from gridslam.level_cloud import LevelCloud
from gridslam.loop_closure import LoopClosureParameters
from gridslam.loop_closure.candidates import Candidate
from gridslam.loop_closure.local_maps.correlation import Window
from gridslam.loop_closure.path.measured_path import MeasuredPath
from gridslam.loop_closure.space.path_clouds import PathClouds
from gridslam.loop_closure.space.space_match import CLIMB_SIGMA_MAX_M, match_in_space
from gridslam.parameters import SlamParameters
from gridslam.saved_sessions import load_session, save_session
from gridslam.scan import PlanarScan
from gridslam.session import SlamSession

P = LoopClosureParameters()
DRIFT = np.array([0.2, 0.1, 0.2])
"""m: by which odometry is off at the end, in x, y and z."""


def round_of(step_m=0.25, rounds=5.5):
    """Places (n, 3) and headings (n,) of rounds in the room; one, after 1.6 of them, is 1.5 m higher."""
    turn = np.arange(0.0, 2 * np.pi * rounds, step_m / 2.0)
    height = 1.0 + 1.5 * np.interp(turn / (2 * np.pi), [1.6, 1.8, 2.6, 2.8], [0.0, 1.0, 1.0, 0.0])
    places = np.column_stack([4.0 + 2.0 * np.cos(turn), 3.5 + 2.0 * np.sin(turn), height])
    return places, se2.wrap(turn + np.pi / 2)


def flown(session, with_clouds=True, drift=DRIFT):
    """Let a session map the rounds; returns the true places at its nodes, and odometry's heights."""
    rng, (places, yaws) = np.random.default_rng(3), round_of()
    nodes = []
    for index, (place, yaw) in enumerate(zip(places, yaws.tolist())):
        seen = cloud(place, heading(yaw), rng)
        told = place + drift * index / len(places)
        level = seen[np.abs(seen[:, 2]) < 0.05 * np.hypot(seen[:, 0], seen[:, 1])]
        angles, ranges = np.arctan2(level[:, 1], level[:, 0]), np.hypot(level[:, 0], level[:, 1])
        scan = PlanarScan(0.5 * index, angles, ranges, (0.0, 0.0, 0.0), 20.0, float(told[2]))
        give = functools.partial(LevelCloud.of, seen, LEVEL, (0.0, 0.0)) if with_clouds else lambda: None
        covariance = np.diag([1e-4 + 1e-5 * index, 1e-4 + 1e-5 * index, 1e-5])
        if session.process(scan, (*told[:2], yaw), covariance, give) is not None:
            nodes.append((*place, told[2]))
    return np.array(nodes)


def session(**options):
    parameters = SlamParameters(seed=1, particles=5, linearUpdate=0.5, angularUpdate=0.5)
    return SlamSession(parameters, say=lambda words: None, odometry_in_space=True, **options)


@pytest.fixture(scope="module")
def with_clouds(tmp_path_factory):
    """A session to its end, its true nodes, and where it was saved before that."""
    mapped, state = session(), tmp_path_factory.mktemp("saved") / "state"
    nodes = flown(mapped)
    save_session(mapped, state)
    mapped.finish()
    return mapped, nodes, state


def test_clouds_correct_the_path_in_space_also_by_places_seen_from_another_height(with_clouds):
    mapped, nodes, _ = with_clouds
    path = mapped.trajectory()
    off = np.column_stack([path.poses_in_map[:, :2], path.heights_m]) - nodes[:, :3]
    off -= off[0]
    assert np.abs(nodes[:, 3] - nodes[:, 2]).max() > 0.18
    assert np.abs(off[:, 2]).max() < 0.08
    assert np.hypot(off[:, 0], off[:, 1]).max() < 0.1
    assert mapped.rise_m == pytest.approx(path.heights_m[-1] - nodes[-1, 3])
    stamps = path.stamps_s.tolist()
    climbs = [
        nodes[stamps.index(each.stamp_to_s), 2] - nodes[stamps.index(each.stamp_from_s), 2]
        for each in mapped.closures
    ]
    assert max(np.abs(climbs)) > 2 * P.height_band_m


def test_without_clouds_heights_stay_as_odometry_tells_them():
    mapped = session()
    nodes = flown(mapped, with_clouds=False)
    mapped.finish()
    np.testing.assert_allclose(mapped.trajectory().heights_m, nodes[:, 3], atol=1e-12)
    assert mapped.rise_m == 0.0


def test_a_saved_session_goes_on_at_its_heights(with_clouds):
    mapped, _, state = with_clouds
    again = load_session(state, odometry_in_space=True)
    again.finish()
    assert again.rise_m == mapped.rise_m != 0.0
    np.testing.assert_array_equal(again.trajectory().heights_m, mapped.trajectory().heights_m)
    np.testing.assert_array_equal(again.trajectory().poses_in_map, mapped.trajectory().poses_in_map)


def test_a_cloud_that_makes_no_sense_is_told_and_the_scan_counts():
    said = []

    def give():
        raise ScanError("The cloud has no x.")

    mapped = SlamSession(SlamParameters(), say=said.append)
    scan = PlanarScan(0.0, np.linspace(-3, 3, 90), np.full(90, 2.0), (0.0, 0.0, 0.0), 10.0)
    assert mapped.process(scan, (0.0, 0.0, 0.0), None, give) is not None
    assert said == ["The cloud has no x. Loop closure does without the cloud."]


# The criterion of a closure


def tried(places, off=(0.0, 0.0, 0.0), risen_m=0.0, planar=None, rays=slice(None), reach_m=1.0):
    """Match the clouds of two places (2, 3) in the room. By the path the second is off by so much."""
    rng, yaws = np.random.default_rng(1), np.array([0.3, -0.2])
    clouds = [
        LevelCloud.of(cloud(place, heading(yaw), rng)[rays], LEVEL, (0.0, 0.0))
        for place, yaw in zip(places, yaws)
    ]
    truth = np.column_stack([np.array(places)[:, :2], yaws])
    heights_m = np.array(places)[:, 2] + (0.0, risen_m)
    poses = np.array([truth[0], se2.compose(truth[1], off)])
    path = MeasuredPath(
        np.array([0.0, 100.0]),
        poses,
        se2.between(poses[:-1], poses[1:]),
        np.zeros((1, 3, 3)),
        poses,
        np.array([0.0, 80.0]),
        heights_m,
        np.diff(heights_m),
    )
    of_path = PathClouds(P)
    of_path.extend(clouds)
    candidate = Candidate(0, 1, Window(se2.between(*poses), reach_m, 0.1), 0.25 * np.eye(3))
    sigmas_m = np.array([0.4, 0.0])
    return match_in_space(candidate, planar, path, of_path, sigmas_m, P), se2.between(*truth)


@pytest.mark.table("risen_m", [0.0, 0.3, -0.3])
def test_a_place_is_found_at_its_true_pose_and_height(risen_m):
    found, truth = tried([(3.0, 3.0, 0.8), (3.4, 3.3, 0.9)], (0.3, -0.2, 0.04), risen_m)
    np.testing.assert_allclose(found.newer_in_older, truth, atol=0.02)
    assert found.climb_m == pytest.approx(0.1, abs=0.03)
    assert 0.02 <= found.climb_sigma_m <= CLIMB_SIGMA_MAX_M


def test_from_a_height_with_no_level_plane_in_common_the_place_is_found_and_the_climb_is_not():
    """From 2.5 m up the rays see neither floor nor deck; the walls fit at any height."""
    found, truth = tried([(3.0, 3.0, 1.5), (3.4, 3.3, 2.5)])
    np.testing.assert_allclose(found.newer_in_older, truth, atol=0.02)
    assert np.isnan(found.climb_m)


def test_one_wall_is_no_place():
    """The beams to one side see a wall; along it the pose stays open."""
    azimuths = np.linspace(-np.pi, np.pi, 360, endpoint=False)
    ahead = np.tile(np.abs(azimuths) < 0.3, 16)
    found, _ = tried([(3.0, 4.5, 2.5), (3.2, 4.5, 2.5)], rays=ahead)
    assert found is None


def test_what_the_path_excludes_is_no_place():
    found, _ = tried([(3.0, 3.0, 1.0), (3.4, 3.3, 1.0)], off=(2.5, 0.0, 0.0), reach_m=3.0)
    assert found is None


def test_level_scans_that_clouds_contradict_close_no_loop():
    places = [(3.0, 3.0, 0.8), (3.4, 3.3, 0.9)]
    good, truth = tried(places)
    assert tried(places, planar=good)[0] is not None
    wrong = dataclasses.replace(good, newer_in_older=se2.compose(truth, (1.5, 0.8, 0.6)))
    assert tried(places, planar=wrong)[0] is None


@pytest.mark.table("points", [np.zeros((3, 2)), np.zeros(3)])
def test_a_cloud_of_another_shape_is_one_sentence(points):
    with pytest.raises(ScanError, match=r"must be \(n, 3\) points"):
        LevelCloud.of(points, LEVEL, (0.0, 0.0))


def test_a_leaning_lidar_gives_a_level_cloud():
    """Given a floor 2 m below, when the UAV pitches by 0.2 rad and rolls by -0.1, the floor stays level."""
    lean = (-0.1, 0.2)
    below = np.array([(x, y, -2.0) for x in range(-3, 4) for y in range(-3, 4)], float)
    seen = np.vstack([below @ matrix_of_lean(*lean), [(np.nan, 0.0, 0.0), (np.inf, 0.0, 0.0)]])
    level = LevelCloud.of(seen, LEVEL, lean)
    np.testing.assert_allclose(level.points_m[:, 2], -2.0, atol=0.003)
    assert len(level.units) == len(below)
