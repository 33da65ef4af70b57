"""The sessions that parameters ask for; what a saved state keeps to itself is told."""

import math

import numpy as np
import pytest

from gridslam import MapError, PlanarScan, SlamParameters
from gridslam.files.map_file import write_map
from gridslam.saved_sessions import save_session
from gridslam.session import SlamSession, closure_parameters

sessions = pytest.importorskip("gridslam_ros.sessions", reason="the workspace is not built, or not sourced")
SMALL = {"particles": 5, "delta": 0.1, "linearUpdate": 0.2}


def square_room_scan(stamp_s):
    """From the middle of a room of 4 x 4 m."""
    angles = np.linspace(-math.pi, math.pi, 120, endpoint=False)
    ranges = 2.0 / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
    return PlanarScan(stamp_s, angles, ranges, (0.0, 0.0, 0.0), 10.0)


@pytest.fixture
def state(tmp_path):
    return saved(tmp_path / "state")


def saved(path, closure=None, **changes):
    session = SlamSession(SlamParameters(**{**SMALL, **changes}), closure)
    session.process(square_room_scan(100.0), (0.0, 0.0, 0.0))
    save_session(session, path)
    return {"continue_from_state": True, "state_file": str(path)}


def first(given):
    said = []
    made = sessions.Sessions(given, said.append)
    return made.first(), said, made


def test_a_new_one_begins_without_a_map():
    session, said, made = first(SMALL)
    assert (session.slam, session.localisation_only, said) == (None, False, [])
    assert session.loop_closure is not None
    assert first({**SMALL, "loop_closure": False})[0].loop_closure is None
    assert made.again == "mapping starts anew"


def test_a_saved_state_is_gone_on_with(state):
    session, said, made = first({**state, **SMALL})
    assert session.trajectory().stamps_s.tolist() == [100.0]
    assert not session.localisation_only
    assert said == []
    assert made.again == "SLAM begins again with the saved state"


def test_localisation_on_a_saved_state_also_after_the_clock_went_back(state):
    session, said, made = first({**state, "localisation_only": True})
    for _ in range(2):
        assert session.localisation_only
        session.process(square_room_scan(5.0), (0.0, 0.0, 0.0))
        before = session.grid().cells
        for step in range(1, 4):
            update = session.process(square_room_scan(5.0 + step), (0.3 * step, 0.0, 0.0))
            assert update is not None
        np.testing.assert_array_equal(session.grid().cells, before)
        session = made.first()
    assert said == []


def test_what_the_state_keeps_is_told(tmp_path):
    plain, closing = tmp_path / "plain", tmp_path / "closing"
    told = {
        "particles, delta": first({**saved(plain), "particles": 7, "delta": 0.05, "linearUpdate": 0.2}),
        "loop_closure": first({**saved(plain), "loop_closure": True, "threads": 2}),
        "closure_score_min, starting_pose": first(
            {
                **saved(closing, closure_parameters({"score_min": 0.8})),
                "loop_closure": True,
                "closure_score_min": 0.7,
                "starting_pose": "1 2 0",
            }
        ),
    }
    for names, (_, said, _) in told.items():
        assert said == [f"The saved state keeps its own {names}, whatever is given now."]
    assert told["loop_closure"][0].parameters.threads == 2


def test_a_state_that_localises_keeps_its_pose(state, tmp_path):
    localising, said, _ = first({**state, "localisation_only": True, "starting_pose": "0.1 0 0"})
    assert said == []
    localising.process(square_room_scan(5.0), (0.0, 0.0, 0.0))
    save_session(localising, tmp_path / "localising")
    again = {**state, "state_file": str(tmp_path / "localising"), "localisation_only": True}
    assert first(again)[1] == []
    _, said, _ = first({**again, "starting_pose": "0.1 0 0"})
    assert said == ["The saved state keeps its own starting_pose, whatever is given now."]


def test_a_starting_map_of_other_cells_is_refused_at_the_start(tmp_path):
    session = SlamSession(SlamParameters(**SMALL))
    session.process(square_room_scan(0.0), (0.0, 0.0, 0.0))
    write_map(tmp_path / "room", session.grid())
    given = {"starting_map": str(tmp_path / "room.yaml")}
    assert first({**given, "delta": 0.1})[0].map_to_odom == (0.0, 0.0, 0.0)
    with pytest.raises(MapError, match=r"0\.1 m wide; set delta to that, it is 0\.05"):
        first({**given, "delta": 0.05})
