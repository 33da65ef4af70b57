"""The filter as a whole, on a simulated room."""

from __future__ import annotations

import copy
import dataclasses
import math

import numpy as np
import plain_filter as reference
import pytest
import rooms
from plain_maps import plain_of
from planar_world import Drift, Lidar, along, drive

from gridslam import GridSlam, MapError, PlanarScan, ScanError, SlamParameters, StateError, se2
from gridslam.evaluation import Walls
from gridslam.files import state_file
from gridslam.filter import proposal
from gridslam.filter.particle_filter import WEIGHT_SMOOTHING
from gridslam.filter.scan_matcher import NULL_LIKELIHOOD_M2
from gridslam.maps import tile_map
from gridslam.maps.beams import Beams


@pytest.fixture(scope="module")
def log():
    return rooms.log()


@pytest.mark.table("seed", [0, 1, 2])
def test_the_path_is_right_where_odometry_is_not(seed):
    log = rooms.log(seed)
    slam = rooms.begin(log, seed=seed)
    rooms.run(slam, log)
    assert np.sqrt(np.mean(rooms.errors(slam, log) ** 2)) <= rooms.RMSE_MAX_M


def test_the_map_is_the_room(log):
    slam = rooms.begin(log)
    rooms.run(slam, log)
    grid = slam.grid()
    distances, _ = rooms.WALLS.distances(grid.occupied_xy())
    # a cell's centre is up to 0.035 m from a wall through it, the path up to rooms.RMSE_MAX_M off
    assert distances.mean() <= 0.035
    assert np.percentile(distances, 95) <= 0.035 + 2.0 * rooms.RMSE_MAX_M
    free = grid.centres(grid.cells == 0)
    assert len(free) * grid.resolution_m**2 == pytest.approx(44.0 - 0.8, rel=0.05)  # the room less the pillar


def test_what_an_update_says(log):
    slam = rooms.begin(log)
    updates = rooms.run(slam, log)
    count = slam.parameters.particles
    assert len(slam.trajectory().stamps_s) == len(updates)
    assert all(update.matched for update in updates)
    assert all(1.0 <= update.neff <= count + 1e-9 for update in updates)
    assert all(0.0 <= update.entropy <= math.log(count) + 1e-9 for update in updates)
    threshold = slam.parameters.resampleThreshold * count
    assert all(update.resampled == (update.neff < threshold) for update in updates)
    assert any(update.resampled for update in updates)
    assert slam.particle_weights.sum() == pytest.approx(1.0)
    assert (updates[0].neff, updates[0].entropy) == (pytest.approx(count), pytest.approx(math.log(count)))


def test_scans_are_processed_after_enough_motion_or_time():
    slam = GridSlam(SlamParameters(particles=2, linearUpdate=1.0, angularUpdate=0.5, temporalUpdate=10.0))
    angles = np.linspace(-3.0, 3.0, 40)

    def process(stamp, *pose):
        scan = PlanarScan(stamp, angles, np.full(40, 2.0), (0.0, 0.0, 0.0), 10.0)
        return slam.process(scan, pose) is not None

    assert process(0.0, 0.0, 0.0, 0.0)  # the first one
    assert not process(1.0, 0.6, 0.0, 0.0)
    assert process(2.0, 0.0, 0.0, 0.0)  # there and back is 1.2 m
    assert not process(3.0, 0.0, 0.0, 0.4)
    assert process(4.0, 0.0, 0.0, 0.5)
    assert not process(13.9, 0.0, 0.0, 0.5)
    assert process(14.1, 0.0, 0.0, 0.5)


def test_between_processed_scans_odometry_carries_the_pose_on(log):
    slam = rooms.begin(log, linearUpdate=100.0, angularUpdate=100.0)
    rooms.run(slam, log, 0, 20)
    start = log.truth.poses_in_map[0]
    expected = se2.compose(start, se2.between(log.odometry[0], log.odometry[19]))
    np.testing.assert_allclose(slam.base_in_map, expected, atol=1e-12)
    again = se2.compose(slam.map_to_odom, log.odometry[19])
    np.testing.assert_allclose(again, expected, atol=1e-12)


def test_same_seed_same_result_and_another_seed_another(log):
    runs = [rooms.begin(log, seed=seed) for seed in (5, 5, 6)]
    for slam in runs:
        rooms.run(slam, log, 0, 80)
    rooms.assert_same(runs[0], runs[1])
    assert (runs[0].particle_poses != runs[2].particle_poses).any()


def test_whether_free_space_waits_changes_nothing(log, monkeypatch, tmp_path):
    runs = []
    for share in (2.0, -1.0):  # never, always
        monkeypatch.setattr(tile_map, "FREE_SHARE", share)
        runs.append(rooms.begin(log, resampleThreshold=0.9))
        updates = rooms.run(runs[-1], log)
        assert sum(update.resampled for update in updates) > 2
    rooms.assert_same(*runs)
    # and a run that is continued from a file in between is the same, too
    rooms.run(saved := rooms.begin(log, resampleThreshold=0.9), log, 0, 77)
    state_file.write(saved.state(), tmp_path / "state")
    rooms.run(loaded := state_file.read(tmp_path / "state", GridSlam.from_state), log, 77)
    rooms.assert_same(runs[0], loaded)


def test_a_run_continued_from_a_file_equals_one_that_was_never_interrupted(log, tmp_path):
    # given a run that is saved between two processed scans, with its scans
    slam = rooms.begin(log, keep_scans=True)
    rooms.run(slam, log, 0, 77)
    state_file.write(slam.state(), tmp_path / "state")
    # when the one loaded from the file and the one in memory go on
    loaded = state_file.read(tmp_path / "state", GridSlam.from_state)
    rooms.assert_same(slam, loaded)
    assert rooms.run(slam, log, 77) == rooms.run(loaded, log, 77)
    # then they are the same to the last bit, and so is what they would do next
    rooms.assert_same(slam, loaded)
    assert len(loaded.processed_scans()) == len(loaded.trajectory().stamps_s)
    slam.adopt(slam.trajectory().poses_in_map)
    loaded.adopt(loaded.trajectory().poses_in_map)
    rooms.assert_same(slam, loaded)


def test_adopting_the_true_path_gives_the_map_made_along_it(log):
    # given a filter that keeps its scans
    slam = rooms.begin(log, keep_scans=True)
    rooms.run(slam, log, 0, 100)
    path = slam.trajectory()
    truth = log.truth.poses_in_map[np.searchsorted(log.truth.stamps_s, path.stamps_s)]
    # when it adopts the truth
    slam.adopt(truth)
    # then path, pose and map are the truth's
    np.testing.assert_array_equal(slam.trajectory().poses_in_map, truth)
    ahead = se2.between(
        log.odometry[np.searchsorted(log.truth.stamps_s, path.stamps_s[-1])], log.odometry[99]
    )
    np.testing.assert_allclose(slam.base_in_map, se2.compose(truth[-1], ahead), atol=1e-12)
    distances, _ = rooms.WALLS.distances(slam.grid().occupied_xy())
    assert distances.mean() <= 0.025
    # and it carries on from there
    rooms.run(slam, log, 100)
    assert np.sqrt(np.mean(rooms.errors(slam, log) ** 2)) <= rooms.RMSE_MAX_M


def test_adopting_needs_scans_and_as_many_poses(log):
    slam = rooms.begin(log)
    rooms.run(slam, log, 0, 3)
    with pytest.raises(StateError, match="keep_scans=True"):
        slam.adopt(np.zeros((1, 3)))
    slam = rooms.begin(log, keep_scans=True)
    rooms.run(slam, log, 0, 3)
    with pytest.raises(StateError, match="must be 1 finite poses"):
        slam.adopt(np.zeros((2, 3)))


def test_a_scan_that_fits_nothing_is_placed_by_odometry():
    # given a minimum score that no scan can reach
    log = rooms.log()
    slam = rooms.begin(log, minimumScore=1e6)
    updates = rooms.run(slam, log, 0, 40)
    assert not any(update.matched for update in updates[1:])
    expected = se2.compose(log.truth.poses_in_map[0], se2.between(log.odometry[0], log.odometry[39]))
    # 4 m in steps of 0.1 m with 0.02 rad each: about 0.3 m to the side at the end
    away = np.hypot(*(slam.particle_poses - expected)[:, :2].T)
    assert away.max() < 4.0 * 0.3
    assert len(np.unique(away)) > 1


@pytest.mark.table("fits", [True, False])
def test_particles_are_weighed_by_the_scan_where_they_have_been_put(log, monkeypatch, fits):
    # given particles that have gone apart, each with its map
    minimum = 0.0 if fits else 1e6
    slam = rooms.begin(log, minimumScore=minimum, resampleThreshold=0.0, temporalUpdate=0.0)
    rooms.run(slam, log, 0, 20)
    parameters, maps = slam.parameters, copy.deepcopy(slam._map.tiles)
    before = np.log(slam.particle_weights)
    # when a scan comes that fits or not, after which they are not scattered
    monkeypatch.setattr(proposal, "SPREAD", 0.0)
    assert slam.process(log.scans[20], log.odometry[20]).matched == fits
    # then each is weighed by that scan's likelihood on its own map at its own pose
    beams = Beams.from_scan(log.scans[20], parameters).matching
    sigma, missed = parameters.lsigma / parameters.delta**2, -NULL_LIKELIHOOD_M2 / parameters.lsigma
    likelihoods = [
        reference.log_likelihood(plain_of(maps, particle), pose, beams, parameters.kernelSize, sigma, missed)
        for particle, pose in enumerate(maps.to_cells(slam.particle_poses))
    ]
    gain = 1.0 / (parameters.ogain * WEIGHT_SMOOTHING)
    expected = before + gain * np.array(likelihoods)
    # (two beams may have lost, or found, their point of the map since Gauss-Newton looked for them)
    tolerance = 1e-4 if not fits else -2.0 * gain * missed
    np.testing.assert_allclose(np.diff(np.log(slam.particle_weights)), np.diff(expected), atol=tolerance)
    assert np.ptp(expected) > 3.0 * tolerance


@pytest.mark.filterwarnings("error")
@pytest.mark.table("far_m", [1e7, 1e30])
def test_a_first_scan_that_is_refused_is_not_remembered(log, far_m):
    slam, first = rooms.begin(log, keep_scans=True), log.scans[0]
    far = dataclasses.replace(first, ranges_m=np.full_like(first.ranges_m, far_m), range_max_m=2 * far_m)
    with pytest.raises(MapError, match="would grow"):
        slam.process(far, log.odometry[0])
    rooms.run(slam, log, 1, 5)
    assert log.scans[0].stamp_s not in slam.trajectory().stamps_s
    assert len(slam.processed_scans()) == len(slam.trajectory().stamps_s) > 0


def test_scans_without_any_return_do_no_harm(log):
    slam = rooms.begin(log)
    rooms.run(slam, log, 0, 30)
    blind = PlanarScan(30.0, np.zeros(0), np.zeros(0), (0.0, 0.0, 0.0), 10.0)
    update = slam.process(blind, se2.compose(log.odometry[30], (1.0, 0.0, 0.0)))
    assert update is not None
    assert not update.matched


def test_odometry_that_is_no_pose_is_refused(log):
    slam = rooms.begin(log)
    with pytest.raises(ScanError, match="base_in_odom must be finite"):
        slam.process(log.scans[0], (math.nan, 0.0, 0.0))


def test_along_a_bare_corridor_the_path_is_odometrys():
    # given walls without an end in sight, and odometry that measures 2 % too much
    walls = Walls.from_polygons([np.array([(-20.0, -1.2), (60.0, -1.2), (60.0, 1.2), (-20.0, 1.2)])])
    lidar, scale = Lidar(4.71, 200, 10.0, 0.01, 10.0), 1.02
    truth, ends = along(np.array([(0.0, 0.0), (20.0, 0.0)]), 0.25), []
    for seed in range(4):
        log = drive(walls, truth, lidar, seed, Drift(scale - 1.0, 0.0, 0.0, 0.0, 0.0))
        slam = GridSlam(SlamParameters(seed=seed))
        rooms.run(slam, log)
        ends.append(slam.base_in_map[:2])
    # then it neither shortens nor stretches what odometry measured, and keeps its lane. Particles spread
    # as odometry does: over 8 seeds the deviation was 0.12 m
    np.testing.assert_allclose(np.mean(ends, axis=0), (20.0 * scale, 0.0), atol=0.2)
