"""A session of SLAM: the filter's answers, and what it adds: odometry that jumps, states, starting maps."""

import dataclasses
import zipfile

import numpy as np
import planar_world
import pytest

from gridslam import ParameterError, SlamParameters, StateError, se2
from gridslam.files import state_file
from gridslam.filter.particle_filter import GridSlam
from gridslam.localisation.relocaliser import Relocaliser
from gridslam.loop_closure.job import Correction, Job
from gridslam.session import SlamSession, closure_parameters

PARAMETERS = SlamParameters(
    particles=5, linearUpdate=0.4, angularUpdate=0.3, delta=0.1, srr=0.02, srt=0.02, stt=0.05
)
LIDAR = planar_world.Lidar(6.2, 180, 20.0, 0.01, 10.0)


@pytest.fixture(scope="module")
def log():
    """One way through the hold: 8 m along, a corner, 4 m more."""
    route = np.array([(-8.0, -5.0), (0.0, -5.0), (0.0, -1.0)])
    return planar_world.drive(planar_world.hold(), planar_world.along(route, 0.2), LIDAR, seed=4)


def run(session, log, first=0, last=None):
    """Feed a part of the log; returns the updates."""
    pairs = list(zip(log.scans, log.odometry))[first:last]
    return [update for update in (session.process(scan, odometry) for scan, odometry in pairs) if update]


def base_in_map(session, base_in_odom):
    return se2.compose(session.map_to_odom, base_in_odom)


def error_m(pose, truth):
    return float(np.hypot(*(np.asarray(pose) - truth)[:2]))


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


@pytest.mark.parametrize("covariance", [np.nan, np.inf, -1.0, 1e12])
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


def test_odometry_that_begins_anew_between_slow_scans_leaves_the_vehicle_in_its_place(log):
    # Given scans every 2.5 s, between two of which odometry begins anew at zero, 9 m away
    middle, states, said = len(log.scans) * 3 // 4, [], []
    session = SlamSession(PARAMETERS, say=said.append)
    for index, (scan, odometry) in enumerate(zip(log.scans, log.odometry)):
        base = odometry if index < middle else se2.between(log.odometry[middle], odometry)
        session.process(dataclasses.replace(scan, stamp_s=2.5 * index), base)
        states.append(session.judgement.state)
    # Then that is said, and the place counts as uncertain until the scans have proved it
    assert len(said) == 1
    assert said[0].startswith("Odometry jumped by")
    assert set(states[:middle]) == {"tracking"}
    assert states[middle] == "uncertain"
    assert states[-1] == "tracking"
    assert error_m(base_in_map(session, base), log.truth.poses_in_map[-1]) < 0.1


def test_a_piece_that_lacks_in_the_log_is_uncertain_until_the_place_is_proved(log):
    # Given scans twice a second, of which those of a whole minute lack
    middle, states = len(log.scans) // 2, []
    session = SlamSession(PARAMETERS)
    for index, (scan, odometry) in enumerate(zip(log.scans, log.odometry)):
        session.process(dataclasses.replace(scan, stamp_s=0.5 * index + 60.0 * (index >= middle)), odometry)
        states.append(session.judgement.state)
    assert set(states[:middle]) == {"tracking"}
    assert states[middle] == "uncertain"
    assert states[-1] == "tracking"


@pytest.mark.parametrize("by", ["initialpose", "search"])
def test_a_correction_begun_before_the_vehicle_was_put_elsewhere_does_not_take_it_back(log, by, monkeypatch):
    # Given a correction of the path that is due at the next scan
    session, middle = SlamSession(PARAMETERS, say=lambda sentence: None), len(log.scans) // 2
    run(session, log, last=middle)
    path, elsewhere = session.trajectory().poses_in_map, np.array((5.0, 3.0, 1.0))
    session._closer.forget()
    due_s = log.scans[middle].stamp_s + 1.0
    session._closer._job = Job(session._closer._thread, 0.0, due_s, lambda: Correction(path))
    # When the vehicle is put elsewhere on the map before that
    if by == "initialpose":
        session.place(elsewhere, 1e-4 * np.eye(3))
    else:
        session.judgement.lose("it was carried")
        monkeypatch.setattr(Relocaliser, "look", lambda self, known, heading_rad: elsewhere)
        while session.judgement.is_lost:
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
    session._closer.forget()
    session.judgement.lose("it was carried")
    search = session._supervisor._relocaliser
    search._frame_in_map = np.array((1.0, 2.0, 0.0))
    before, moved = session.grid().origin_xy_m[0], se2.compose((7.0, 0, 0), session.trajectory().poses_in_map)
    session._closer._job = Job(session._closer._thread, 0.0, 0.0, lambda: Correction(moved))
    # When the map is corrected
    sought = []
    monkeypatch.setattr(Relocaliser, "_unique", lambda self, known, heading: sought.append(known.grid()))
    for scan, odometry in list(zip(log.scans, log.odometry))[middle : middle + 8]:
        session.process(scan, odometry)
    # Then the place on the old map counts no more, and the search is on the corrected one
    assert search._frame_in_map is None
    assert sought[0].origin_xy_m[0] - before == pytest.approx(7.0, abs=2.0)


def test_a_run_continued_from_its_state_equals_one_that_was_never_interrupted(tmp_path):
    # Given a round trip and a bit more, interrupted when loops have been closed
    corners = [(-8.0, -5.0), (-2.0, -5.0), (-2.0, -1.0), (-8.0, -1.0), (-8.0, -5.0), (-2.0, -5.0)]
    log = planar_world.drive(planar_world.hold(), planar_world.along(np.array(corners), 0.4), LIDAR, seed=4)
    near = {"separation_m": 15.0, "stretch_m": 7.0, "support_m": 5.0, "search_agreed_m": 0.5}
    closure = closure_parameters(near)
    whole, begun = SlamSession(PARAMETERS, closure), SlamSession(PARAMETERS, closure)
    run(whole, log)
    run(begun, log, last=-12)
    assert len(begun.closures) > 0
    begun.save(tmp_path / "state")
    continued = SlamSession.load(tmp_path / "state")
    assert [path.name for path in tmp_path.iterdir()] == ["state"]
    assert continued.closures == begun.closures
    run(continued, log, first=-12)
    assert continued.map_to_odom == whole.map_to_odom
    np.testing.assert_array_equal(continued.particle_poses, whole.particle_poses)
    for session in (whole, continued):
        session.finish()
    assert continued.closures == whole.closures
    np.testing.assert_array_equal(continued.trajectory().stamps_s, whole.trajectory().stamps_s)
    np.testing.assert_array_equal(continued.trajectory().poses_in_map, whole.trajectory().poses_in_map)
    np.testing.assert_array_equal(continued.grid().cells, whole.grid().cells)


@pytest.mark.parametrize("scans", [21, 22])
def test_a_run_with_told_covariances_goes_on_as_if_never_interrupted(log, tmp_path, scans):
    def go(session, first, last):
        for k in range(first, last):
            # with a scan in between that is told none
            told = None if k == 20 else np.diag((1e-3, 2e-3, 5e-4)) * (1.0 + 0.3 * k)
            session.process(log.scans[k], log.odometry[k], told)

    # Given a run that is saved between two scans that were processed
    whole, begun = SlamSession(PARAMETERS), SlamSession(PARAMETERS)
    go(whole, 0, len(log.scans))
    go(begun, 0, scans)
    begun.save(tmp_path / "state")
    # When it goes on from the state
    continued = SlamSession.load(tmp_path / "state")
    go(continued, scans, len(log.scans))
    # Then it is the run that was never interrupted, bit for bit
    np.testing.assert_array_equal(continued.particle_poses, whole.particle_poses)
    np.testing.assert_array_equal(continued.trajectory().poses_in_map, whole.trajectory().poses_in_map)
    np.testing.assert_array_equal(continued.grid().cells, whole.grid().cells)


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


def test_localisation_on_a_saved_state_leaves_its_map_as_it_is(log, tmp_path):
    mapped = SlamSession(PARAMETERS)
    run(mapped, log)
    mapped.save(tmp_path / "state")
    # Given the saved state, a clock and odometry of their own, and people about, 1 m off the lidar
    session = SlamSession.load(
        tmp_path / "state", localisation_only=True, starting_pose=tuple(log.truth.poses_in_map[0]), threads=2
    )
    assert session.localisation_only
    assert session.parameters.threads == 2
    assert session.map_to_odom is None
    for index, (scan, odometry) in enumerate(zip(log.scans, log.odometry)):
        ranges_m = np.where(np.arange(scan.ranges_m.size) % 10 == 0, 1.0, scan.ranges_m)
        changed = dataclasses.replace(scan, stamp_s=0.5 * index, ranges_m=ranges_m)
        session.process(changed, se2.compose((5.0, 5.0, 1.0), odometry))
    # Then the vehicle finds itself, its path is of this run alone, and the map is as it was
    here = base_in_map(session, se2.compose((5.0, 5.0, 1.0), log.odometry[-1]))
    assert error_m(here, log.truth.poses_in_map[-1]) < 0.1
    assert np.all(np.diff(session.trajectory().stamps_s) > 0.0)
    assert session.trajectory().stamps_s[0] == 0.0
    np.testing.assert_array_equal(session.grid().cells, mapped.grid().cells)
    # And so it goes on from a state of its own
    session.save(tmp_path / "again")
    again = SlamSession.load(tmp_path / "again", localisation_only=True)
    assert again.localisation_only
    assert again.map_to_odom == session.map_to_odom


def test_localisation_begins_where_the_state_ended(log, tmp_path):
    mapped = SlamSession(PARAMETERS)
    run(mapped, log)
    mapped.save(tmp_path / "state")
    session = SlamSession.load(tmp_path / "state", localisation_only=True)
    session.process(dataclasses.replace(log.scans[-1], stamp_s=0.0), (0.0, 0.0, 0.0))
    assert error_m(base_in_map(session, (0.0, 0.0, 0.0)), log.truth.poses_in_map[-1]) < 0.1


def test_before_the_first_scan_there_is_nothing(tmp_path):
    session = SlamSession(PARAMETERS)
    assert session.slam is None
    assert session.trajectory().poses_in_map.shape == (0, 3)
    assert session.particle_poses.shape == (0, 3)
    assert (session.entropy, session.closures) == (0.0, [])
    for ask in (session.grid, lambda: session.save(tmp_path / "state")):
        with pytest.raises(StateError, match="before the first scan"):
            ask()


def test_states_that_cannot_be_written_or_read(log, tmp_path):
    session = SlamSession(PARAMETERS)
    run(session, log, last=1)
    with pytest.raises(StateError, match="cannot be written"):
        session.save(tmp_path / "no/folder/state")
    (tmp_path / "junk").write_text("junk")
    with zipfile.ZipFile(tmp_path / "other.zip", "w") as other:
        other.writestr("a", "b")
    for name in ("nothing", "junk", "other.zip"):
        with pytest.raises(StateError, match=name):
            SlamSession.load(tmp_path / name)


def test_a_state_of_an_earlier_version_is_refused_in_one_sentence(log, tmp_path, monkeypatch):
    session = SlamSession(PARAMETERS)
    run(session, log, last=5)
    with monkeypatch.context() as earlier:
        earlier.setattr(state_file, "FORMAT", state_file.FORMAT - 1)
        session.save(tmp_path / "old")
    with pytest.raises(
        StateError, match=r"old is of another version \(\d\) of gridslam.* as starting_map\.$"
    ):
        SlamSession.load(tmp_path / "old")


@pytest.mark.parametrize(
    ("later_s", "moved_m", "state"),
    [(0.0, 0.0, "tracking"), (-1000.0, 0.0, "uncertain"), (0.0, 30.0, "uncertain")],
)
def test_another_clock_or_odometry_after_a_saved_state_is_a_new_flight(
    log, tmp_path, later_s, moved_m, state
):
    session = SlamSession(PARAMETERS)
    run(session, log, last=8)
    session.save(tmp_path / "state")
    session = SlamSession.load(tmp_path / "state", say=lambda sentence: None)
    scan = dataclasses.replace(log.scans[8], stamp_s=log.scans[8].stamp_s + later_s)
    session.process(scan, log.odometry[8] + (moved_m, 0.0, 0.0))
    assert session.judgement.state == state


def test_the_parameters_of_loop_closure_are_checked_by_name():
    assert closure_parameters({"score_min": 0.8}).score_min == 0.8
    with pytest.raises(ParameterError, match="no parameter radius"):
        closure_parameters({"radius": 1.0})


def test_a_saved_session_with_damaged_parts_is_refused_by_its_own_name(log, tmp_path):
    session = SlamSession(PARAMETERS)
    run(session, log, last=5)
    session.save(tmp_path / "whole")
    with zipfile.ZipFile(tmp_path / "whole") as whole:
        parts = {name: whole.read(name) for name in whole.namelist()}
    nonsense = {
        "filter": b"no arrays",
        "judgement.json": b'{"state": "happy"}',
        "odometry.json": b'{"last_s": "now", "last": [0, 0, 0], "odom": [0, 0, 0]}',
        "supervisor.npz": b"no arrays",
    }
    assert nonsense.keys() <= parts.keys()
    short = ("odometry.json", b'{"last_s": 1.0, "last": [0, 0], "odom": [0, 0, 0]}')
    for name, content in (*nonsense.items(), short):
        path = tmp_path / "damaged"
        with zipfile.ZipFile(path, "w") as damaged:
            for part, kept in parts.items():
                damaged.writestr(part, content if part == name else kept)
        with pytest.raises(StateError) as told:
            SlamSession.load(path)
        assert str(told.value).startswith(f"{path} ")
        assert str(told.value).count("/tmp") <= str(path).count("/tmp")
    # And cut off anywhere
    whole = (tmp_path / "whole").read_bytes()
    for share in (0.0, 0.3, 0.9, 0.999):
        path.write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(StateError, match="cannot be read as a saved state"):
            SlamSession.load(path)
