"""A session of SLAM: the filter's answers, and what it adds: odometry that jumps, states, starting maps."""

import dataclasses

import numpy as np
import planar_world
import pytest
from sessions_in_the_hold import PARAMETERS, base_in_map, error_m, run, way_through_the_hold

from gridslam import StateError, se2
from gridslam.evaluation import Walls
from gridslam.filter.grid_slam import GridSlam
from gridslam.localisation.relocaliser import Relocaliser
from gridslam.loop_closure.background import BackgroundWork
from gridslam.loop_closure.correction import Correction
from gridslam.saved_sessions import save_session
from gridslam.session import SlamSession


@pytest.fixture(scope="module")
def log():
    return way_through_the_hold()


def test_it_is_the_filter_that_answers(log):
    session, slam = SlamSession(PARAMETERS), GridSlam(PARAMETERS, starting_pose=tuple(log.odometry[0]))
    run(session, log)
    for scan, odometry in zip(log.scans, log.odometry):
        slam.process(scan, tuple(odometry))
    np.testing.assert_array_equal(session.trajectory().poses_in_map, slam.trajectory().poses_in_map)
    np.testing.assert_array_equal(session.grid().cells, slam.grid().cells)
    np.testing.assert_allclose(session.map_to_odom, slam.map_to_odom, atol=1e-12)


def test_map_and_odometry_begin_as_one(log):
    session = SlamSession(PARAMETERS)
    assert session.map_to_odom == (0.0, 0.0, 0.0)
    run(session, log, last=1)
    np.testing.assert_allclose(session.map_to_odom, 0.0, atol=1e-9)
    assert error_m(base_in_map(session, log.odometry[0]), log.truth.poses_in_map[0]) < 1e-6


def test_a_reset_of_odometry_does_not_move_the_vehicle(log):
    # Given odometry that begins anew, at zero, in the middle of the run
    middle = len(log.scans) // 2
    said = []
    session = SlamSession(PARAMETERS, say=said.append)
    run(session, log, last=middle)
    for scan, odometry in list(zip(log.scans, log.odometry))[middle:]:
        reset = se2.compose((40.0, 30.0, 2.0), se2.between(log.odometry[middle], odometry))
        session.process(scan, reset)
    # Then the vehicle is where it is, in the map and by map -> odom
    assert len(said) == 1
    truth = log.truth.poses_in_map[-1]
    assert (
        error_m(session.trajectory().poses_in_map[-1], truth) < 0.45 + 0.1
    )  # the last scan may wait for motion
    assert error_m(base_in_map(session, reset), truth) < 0.1


@pytest.mark.table("covariance", [np.nan, np.inf, -1.0, 1e12])
def test_a_covariance_that_tells_nothing_counts_as_none(log, covariance):
    # Given odometry that tells its covariance, but for some scans in the middle
    told = np.arange(len(log.scans))[:, None, None] * 1e-4 * np.eye(3)
    said, paths = [], []
    for untold in (np.full((3, 3), covariance), None):
        session = SlamSession(PARAMETERS, False, say=said.append)
        for k, (scan, odometry) in enumerate(zip(log.scans, log.odometry)):
            session.process(scan, odometry, untold if 20 <= k < 23 else told[k])
        paths.append(session.trajectory().poses_in_map)
    # Then the run is that in which these scans tell none, and it says so
    np.testing.assert_array_equal(*paths)
    assert len(said) == 3
    assert "srr, srt, str and stt count instead" in said[0]


def test_odometry_that_begins_anew_leaves_the_vehicle_in_its_place(log):
    # Given scans every 2.5 s, between two of which odometry begins anew at zero, 9 m away
    middle, states, said = len(log.scans) * 3 // 4, [], []
    session = SlamSession(PARAMETERS, say=said.append)
    for index, (scan, odometry) in enumerate(zip(log.scans, log.odometry)):
        base = odometry if index < middle else se2.between(log.odometry[middle], odometry)
        session.process(dataclasses.replace(scan, stamp_s=2.5 * index), base)
        states.append(session.tracking.state)
    # Then that is said, and the place counts as uncertain until the scans have proved it
    assert len(said) == 1
    assert said[0].startswith("Odometry jumped by")
    assert set(states[:middle]) == {"tracking"}
    assert states[middle] == "uncertain"
    assert states[-1] == "tracking"
    assert error_m(base_in_map(session, base), log.truth.poses_in_map[-1]) < 0.1


def test_a_gap_in_the_log_is_uncertain_until_the_place_is_proved(log):
    # Given scans twice a second, of which those of a whole minute lack
    middle, states = len(log.scans) // 2, []
    session = SlamSession(PARAMETERS)
    for index, (scan, odometry) in enumerate(zip(log.scans, log.odometry)):
        session.process(dataclasses.replace(scan, stamp_s=0.5 * index + 60.0 * (index >= middle)), odometry)
        states.append(session.tracking.state)
    assert set(states[:middle]) == {"tracking"}
    assert states[middle] == "uncertain"
    assert states[-1] == "tracking"


@pytest.mark.table("by", ["initialpose", "search"])
def test_an_earlier_correction_does_not_take_a_relocated_vehicle_back(log, by, monkeypatch):
    # Given a correction of the path that is due at the next scan
    session, middle = SlamSession(PARAMETERS, say=lambda sentence: None), len(log.scans) // 2
    run(session, log, last=middle)
    path, elsewhere = session.trajectory().poses_in_map, np.array((5.0, 3.0, 1.0))
    session._closer.drop()
    due_s = log.scans[middle].stamp_s + 1.0
    session._closer._work = BackgroundWork(session._closer._thread, 0.0, due_s, lambda: Correction(path))
    # When the vehicle is put elsewhere on the map before that
    if by == "initialpose":
        session.place(elsewhere, 1e-4 * np.eye(3))
    else:
        session.tracking.lose("it was carried")
        monkeypatch.setattr(Relocaliser, "look", lambda self, known, heading_rad: elsewhere)
        while session.tracking.is_lost:
            session.process(log.scans[middle], log.odometry[middle])
            middle += 1
    # Then it goes on from there, when the correction would have been due, too
    before = base_in_map(session, log.odometry[middle - 1])
    assert error_m(before, elsewhere) < 0.05
    late = dataclasses.replace(log.scans[middle], stamp_s=log.scans[middle].stamp_s + 5.0)
    session.process(late, log.odometry[middle])
    assert error_m(base_in_map(session, log.odometry[middle]), before) < 1.0


def test_a_place_found_before_a_correction_of_the_map_is_looked_for_anew(log, monkeypatch):
    # Given a lost vehicle, a place that was found, and a correction that moves the whole map
    session, middle = SlamSession(PARAMETERS, say=lambda sentence: None), len(log.scans) // 2
    run(session, log, last=middle)
    session._closer.drop()
    session.tracking.lose("it was carried")
    search = session._supervisor._relocaliser
    search._frame_in_map = np.array((1.0, 2.0, 0.0))
    before, moved = session.grid().origin_xy_m[0], se2.compose((7.0, 0, 0), session.trajectory().poses_in_map)
    session._closer._work = BackgroundWork(session._closer._thread, 0.0, 0.0, lambda: Correction(moved))
    # When the map is corrected
    sought = []
    monkeypatch.setattr(Relocaliser, "_unique", lambda self, known, heading: sought.append(known.grid()))
    for scan, odometry in list(zip(log.scans, log.odometry))[middle : middle + 8]:
        session.process(scan, odometry)
    # Then the place on the old map counts no more, and the search is on the corrected one
    assert search._frame_in_map is None
    assert sought[0].origin_xy_m[0] - before == pytest.approx(7.0, abs=2.0)


def test_a_starting_map_tells_where_the_vehicle_is(log):
    mapped = SlamSession(PARAMETERS)
    run(mapped, log)
    # Given the map of an earlier run, a pose that is 0.2 m off, and odometry of another origin
    truth = log.truth.poses_in_map
    off = (truth[0, 0] + 0.15, truth[0, 1] - 0.1, truth[0, 2])
    session = SlamSession(PARAMETERS, starting_map=mapped.grid(), starting_pose=off, localisation_only=True)
    assert session.map_to_odom is None
    before = mapped.grid()
    for scan, odometry in zip(log.scans, log.odometry):
        shifted = se2.compose((5.0, 5.0, 1.0), odometry)
        session.process(scan, shifted)
    # Then it finds itself in the map, which stays as it is
    assert error_m(base_in_map(session, shifted), truth[-1]) < 0.15
    after = session.grid()
    np.testing.assert_array_equal(after.occupied_xy(), before.occupied_xy())


def test_before_the_first_scan_there_is_nothing(tmp_path):
    session = SlamSession(PARAMETERS)
    assert session.slam is None
    assert session.trajectory().poses_in_map.shape == (0, 3)
    assert session.particle_poses.shape == (0, 3)
    assert (session.entropy, session.closures) == (0.0, [])
    for ask in (session.grid, lambda: save_session(session, tmp_path / "state")):
        with pytest.raises(StateError, match="before the first scan"):
            ask()


def test_odometry_that_is_5_percent_long_in_a_bare_corridor_is_not_tracked():
    # Given a dense and noisy lidar, whose single beams seem to measure the way along the walls
    walls = Walls.from_polygons([np.array([(-3.0, -1.25), (60.0, -1.25), (60.0, 1.25), (-3.0, 1.25)])])
    truth = planar_world.along(np.array([(0.0, 0.0), (30.0, 0.0)]), 0.5)
    lidar = planar_world.Lidar(6.28, 720, 12.0, 0.02, 10.0)
    drift = planar_world.Drift(0.05, 0.0, 0.01, 0.002, 0.005)
    way = planar_world.drive(walls, truth, lidar, seed=1, drift=drift)
    session, off_m, states = SlamSession(PARAMETERS, starting_pose=(0.0, 0.0, 0.0)), [], []
    for scan, odometry, true in zip(way.scans, way.odometry, truth):
        session.process(scan, odometry)
        off_m.append(error_m(base_in_map(session, odometry), true))
        states.append(session.told_state)
    # Then the pose is as wrong as odometry, and the state says so
    assert off_m[-1] > 1.0
    assert states[5] == "tracking"
    assert "tracking" not in {state for state, off in zip(states, off_m) if off > 0.6}


def blind(scan):
    return dataclasses.replace(scan, ranges_m=np.full_like(scan.ranges_m, np.inf))


@pytest.mark.table("how", ["no return", "no scan", "no message"])
def test_without_sight_the_state_ends_and_comes_back_by_evidence(log, how):
    # Given a lidar that sees nothing in the middle of the way, or is silent, with odometry or without
    first, last, told = len(log.scans) // 3, len(log.scans) // 3 + 30, []
    session = SlamSession(PARAMETERS, say=lambda sentence: None)
    for index, (scan, odometry) in enumerate(zip(log.scans, log.odometry)):
        if not first <= index < last:
            session.process(scan, odometry)
        elif how == "no return":
            session.process(blind(scan), odometry)
        else:
            session.go_on(scan.stamp_s, odometry if how == "no scan" else None)
        told.append(session.told_state)
    assert told[first - 1] == "tracking"
    # Then the state is not tracking when that has lasted for 15 s, and it tells the age of what it rests on
    assert told[last - 1] in ("uncertain", "lost")
    assert "tracking" not in told[last - 5 : last]
    # and the scans that come again prove the place
    assert told[last] == "uncertain"
    assert set(told[last + 6 :]) <= {"tracking", "drifting"}
    assert session.sight.age_s == 0.0


def test_without_sight_a_long_way_by_odometry_is_lost_and_standing_still_is_not():
    session = SlamSession(PARAMETERS, say=lambda sentence: None)
    way = way_through_the_hold()
    run(session, way, last=20)
    stamp_s, (x, y, yaw) = way.scans[19].stamp_s, way.odometry[19]
    for second in range(1, 60):
        session.go_on(stamp_s + second, (x, y, yaw))
    assert (session.told_state, session.sight.age_s) == ("uncertain", 59.0)
    # 1 m: by srr, per metre of way
    for metre in range(int(1.0 / PARAMETERS.srr) + 2):
        session.go_on(stamp_s + 60.0 + metre, (x + metre, y, yaw))
    assert session.told_state == "lost"
    assert not session.tracking.is_lost  # nothing searches without sight, and no map begins


def test_a_short_time_without_sight_does_no_harm(log):
    states, session = [], SlamSession(PARAMETERS, say=lambda sentence: None)
    for index, (scan, odometry) in enumerate(zip(log.scans, log.odometry)):
        session.process(blind(scan) if index in (30, 31) else scan, odometry)
        states.append(session.told_state)
    assert set(states) == {"tracking"}
    assert error_m(base_in_map(session, log.odometry[-1]), log.truth.poses_in_map[-1]) < 0.1


def test_while_odometry_is_in_doubt_the_state_is_uncertain(log):
    states, session = [], SlamSession(PARAMETERS, say=lambda sentence: None)
    for index, (scan, odometry) in enumerate(zip(log.scans, log.odometry)):
        session.process(scan, odometry, in_doubt="two sources" if 20 <= index < 40 else "")
        states.append(session.told_state)
    assert set(states[:20]) == {"tracking"}
    assert set(states[20:40]) == {"uncertain"}
    assert states[-1] == "tracking"


@pytest.mark.table("begins_anew", [False, True])
def test_a_map_that_begins_in_flight_goes_on_in_the_frame_of_the_one_before(log, begins_anew):
    # Given a session that is gone in the middle of the run, and a new one that knows its last place
    middle, said = len(log.scans) // 2, []
    before = SlamSession(PARAMETERS)
    run(before, log, last=middle)
    session = SlamSession(PARAMETERS, say=said.append)
    session.follow_former(before.map_to_odom, log.odometry[middle - 1])
    states = []
    for scan, odometry in list(zip(log.scans, log.odometry))[middle:]:
        base = se2.between(log.odometry[middle], odometry) if begins_anew else odometry
        session.process(scan, base)
        states.append(session.told_state)
    # Then the frame has not jumped, and the state does not say that the place in it is proved
    assert set(states) == {"uncertain"}
    step_m = error_m(log.truth.poses_in_map[middle], log.truth.poses_in_map[middle - 1])
    limit_m = 0.2 + (step_m if begins_anew else 0.0)
    assert error_m(base_in_map(session, base), log.truth.poses_in_map[-1]) < limit_m
