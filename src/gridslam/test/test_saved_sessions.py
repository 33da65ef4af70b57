"""Saved sessions go on as if they were never interrupted; what is damaged or old is refused."""

import dataclasses
import zipfile

import numpy as np
import planar_world
import pytest
from sessions_in_the_hold import LIDAR, PARAMETERS, base_in_map, error_m, run, way_through_the_hold

from gridslam import StateError, se2
from gridslam.files import state_file
from gridslam.saved_sessions import load_session, save_session
from gridslam.session import SlamSession, closure_parameters


@pytest.fixture(scope="module")
def log():
    return way_through_the_hold()


def test_a_run_continued_from_its_state_equals_an_uninterrupted_one(tmp_path):
    # Given a round trip and a bit more, interrupted when loops have been closed
    corners = [(-8.0, -5.0), (-2.0, -5.0), (-2.0, -1.0), (-8.0, -1.0), (-8.0, -5.0), (-2.0, -5.0)]
    log = planar_world.drive(planar_world.hold(), planar_world.along(np.array(corners), 0.4), LIDAR, seed=4)
    near = {"separation_m": 15.0, "stretch_m": 7.0, "support_m": 5.0, "search_agreed_m": 0.5}
    closure = closure_parameters(near)
    whole, begun = SlamSession(PARAMETERS, closure), SlamSession(PARAMETERS, closure)
    run(whole, log)
    run(begun, log, last=-12)
    assert len(begun.closures) > 0
    save_session(begun, tmp_path / "state")
    continued = load_session(tmp_path / "state")
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


@pytest.mark.table("scans", [21, 22])
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
    save_session(begun, tmp_path / "state")
    # When it goes on from the state
    continued = load_session(tmp_path / "state")
    go(continued, scans, len(log.scans))
    # Then it is the run that was never interrupted, bit for bit
    np.testing.assert_array_equal(continued.particle_poses, whole.particle_poses)
    np.testing.assert_array_equal(continued.trajectory().poses_in_map, whole.trajectory().poses_in_map)
    np.testing.assert_array_equal(continued.grid().cells, whole.grid().cells)


def test_localisation_on_a_saved_state_leaves_its_map_as_it_is(log, tmp_path):
    mapped = SlamSession(PARAMETERS)
    run(mapped, log)
    save_session(mapped, tmp_path / "state")
    # Given the saved state, a clock and odometry of their own, and people about, 1 m off the lidar
    session = load_session(
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
    save_session(session, tmp_path / "again")
    again = load_session(tmp_path / "again", localisation_only=True)
    assert again.localisation_only
    assert again.map_to_odom == session.map_to_odom


def test_localisation_begins_where_the_state_ended(log, tmp_path):
    mapped = SlamSession(PARAMETERS)
    run(mapped, log)
    save_session(mapped, tmp_path / "state")
    session = load_session(tmp_path / "state", localisation_only=True)
    session.process(dataclasses.replace(log.scans[-1], stamp_s=0.0), (0.0, 0.0, 0.0))
    assert error_m(base_in_map(session, (0.0, 0.0, 0.0)), log.truth.poses_in_map[-1]) < 0.1


def test_states_that_cannot_be_written_or_read(log, tmp_path):
    session = SlamSession(PARAMETERS)
    run(session, log, last=1)
    with pytest.raises(StateError, match="cannot be written"):
        save_session(session, tmp_path / "no/folder/state")
    (tmp_path / "junk").write_text("junk")
    with zipfile.ZipFile(tmp_path / "other.zip", "w") as other:
        other.writestr("a", "b")
    for name in ("nothing", "junk", "other.zip"):
        with pytest.raises(StateError, match=name):
            load_session(tmp_path / name)


def test_a_state_of_an_earlier_version_is_refused_in_one_sentence(log, tmp_path, monkeypatch):
    session = SlamSession(PARAMETERS)
    run(session, log, last=5)
    with monkeypatch.context() as earlier:
        earlier.setattr(state_file, "FORMAT", state_file.FORMAT - 1)
        save_session(session, tmp_path / "old")
    with pytest.raises(
        StateError, match=r"old is of another version \(\d+\) of gridslam.* as starting_map\.$"
    ):
        load_session(tmp_path / "old")


@pytest.mark.table(
    ("later_s", "moved_m", "state"),
    [(0.0, 0.0, "tracking"), (-1000.0, 0.0, "uncertain"), (0.0, 30.0, "uncertain")],
)
def test_another_clock_or_odometry_after_a_saved_state_is_a_new_flight(
    log, tmp_path, later_s, moved_m, state
):
    session = SlamSession(PARAMETERS)
    run(session, log, last=8)
    save_session(session, tmp_path / "state")
    session = load_session(tmp_path / "state", say=lambda sentence: None)
    scan = dataclasses.replace(log.scans[8], stamp_s=log.scans[8].stamp_s + later_s)
    session.process(scan, log.odometry[8] + (moved_m, 0.0, 0.0))
    assert session.tracking.state == state


def test_states_of_formats_up_to_9_are_refused_likewise(tmp_path):
    with zipfile.ZipFile(tmp_path / "old", "w") as old:
        for name in ("filter", "odometry.json", "judgement.json", "supervisor.npz"):
            old.writestr(name, "content")
    with pytest.raises(StateError, match=r"old is of another version \(9 or older\).* as starting_map\.$"):
        load_session(tmp_path / "old")


def test_a_saved_session_with_damaged_parts_is_refused_by_its_own_name(log, tmp_path):
    session = SlamSession(PARAMETERS)
    run(session, log, last=5)
    save_session(session, tmp_path / "whole")
    state = state_file.read(tmp_path / "whole", lambda state: state)
    path = tmp_path / "damaged"
    for name, nonsense in (
        ("filter", None),
        ("tracking", "happy"),
        ("odometry", np.zeros(3)),
        ("supervisor", {}),
        ("closer", state.supervisor),
    ):
        state_file.write(dataclasses.replace(state, **{name: nonsense}), path)
        with pytest.raises(StateError) as told:
            load_session(path)
        assert str(told.value).startswith(f"{path} cannot be read as a saved state")
    # And cut off anywhere
    whole = (tmp_path / "whole").read_bytes()
    for share in (0.0, 0.3, 0.9, 0.999):
        path.write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(StateError, match="cannot be read as a saved state"):
            load_session(path)


def test_a_filter_alone_is_no_session(log, tmp_path):
    session = SlamSession(PARAMETERS)
    run(session, log, last=5)
    state_file.write(session.slam.state(), tmp_path / "state")
    with pytest.raises(StateError, match="cannot be read as a saved state"):
        load_session(tmp_path / "state")
