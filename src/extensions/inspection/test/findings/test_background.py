"""A search in another process answers with nearer photographs, and what was searched is remembered."""

import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from drawn_wall import CAMERA, wall_picture
from scipy.spatial.transform import Rotation

from flight_basics.errors import SurveyError
from inspection.camera.survey_camera import SurveyCamera, optical_axes
from inspection.findings import search as searching
from inspection.findings.background import BackgroundSearch, SearchTargets
from inspection.findings.follower import follow
from inspection.findings.parameters import FindingParameters
from inspection.findings.search import find
from inspection.photographs.folder import PhotographFolder
from inspection.photographs.listing import photographs_in
from inspection.photographs.record import PhotographRecord
from inspection.survey.parameters import FlightParameters, SurveyParameters
from inspection.survey.plan import Draft, Flight, PlannedView, SurveyPlan
from inspection.survey.plan_file import read_plan, write_plan
from inspection.survey.views.candidates import View

PLACE_M = (0.8, 0.0, 1.5)


@pytest.fixture
def survey(tmp_path):
    """A room with a photograph of its wall, and the plan, whose camera could look from 1 m away."""
    store = PhotographFolder(tmp_path / "shots", CAMERA)
    turn = tuple(Rotation.from_matrix(optical_axes(0.0, 0.0)).as_quat())
    store.save(wall_picture(), PhotographRecord(0.0, PLACE_M, turn, 0.002, 100.0, 100.0))
    room = trimesh.creation.box((3.0, 4.0, 3.0))
    room.apply_translation((0.0, 0.0, 1.5))
    room.export(tmp_path / "room.stl")
    view, asked = PlannedView(View(PLACE_M, 0.0, 0.0)), SurveyParameters(voxel=0.2, radius=0.2)
    camera = SurveyCamera(4000, 3000, 60.0)
    plan = SurveyPlan(
        str(tmp_path / "room.stl"),
        (0.0, 0.0, 1.5),
        camera,
        asked,
        FlightParameters(),
        (Flight((view,), 9.0, 1.0),),
    )
    write_plan(tmp_path / "plan.yaml", plan)
    return tmp_path


CRACKS = SearchTargets(open=False, cracks=True)


def answered(search, longest_s=60.0):
    until, answer = time.monotonic() + longest_s, None
    while answer is None and time.monotonic() < until:
        time.sleep(0.05)
        answer = search.take_answer()
    search.close()
    assert answer is not None
    return answer


def test_a_photograph_is_searched_in_another_process(survey):
    search = BackgroundSearch(survey / "plan.yaml", survey / "closer.yaml", CRACKS)
    for path in photographs_in(survey / "shots"):
        search.add(path)
    search.ask()
    answer = answered(search)
    (view,) = answer.views
    assert "1 rust spots and 1 cracks" in answer.says
    crack_m = -(500.5 - CAMERA.centre_px[0]) * 0.7 / CAMERA.focal_px
    assert abs(view.place_m[1] - crack_m) < 0.2
    (stored,) = read_plan(survey / "closer.yaml").views
    assert np.allclose(stored.place_m, view.place_m, atol=1e-3)


def test_what_no_photograph_shows_is_asked_for_first(survey):
    (path,) = photographs_in(survey / "shots")
    lines = [f"{path}\n", "[]\n", "[]\n", "[]\n"]
    answers = list(follow(survey / "plan.yaml", survey / "closer.yaml", SearchTargets(), lines))
    assert [each["is_last"] for each in answers] == [False, False, True]
    assert len(answers[0]["views"]) > 3
    assert "1 rust spots and 1 cracks" in answers[-1]["says"]
    # When the UAV could not go anywhere near a place, none is asked for there
    x, y, z, *_ = answers[0]["views"][0]
    again = list(
        follow(
            survey / "plan.yaml", survey / "closer.yaml", SearchTargets(), [lines[0], f"[[{x}, {y}, {z}]]"]
        )
    )
    assert all(np.linalg.norm(np.subtract(each[:3], (x, y, z))) > 0.5 for each in again[0]["views"])


def test_a_draft_is_completed_before_its_photographs_are_searched(survey):
    drafted = replace(read_plan(survey / "plan.yaml"), draft=Draft(seed=1, search_s=0.0))
    write_plan(survey / "plan.yaml", drafted)
    search = BackgroundSearch(survey / "plan.yaml", survey / "closer.yaml", SearchTargets(False, False))
    answer = answered(search)  # nobody has asked
    assert not answer.is_last
    assert "The plan is complete" in answer.says
    whole = read_plan(survey / "plan.yaml")
    assert whole.draft is None
    assert whole.views[0] == drafted.views[0]
    assert len(answer.views) == len(whole.views) - 1 > 3
    np.testing.assert_allclose(answer.views[0].place_m, whole.views[1].place_m, atol=1e-3)
    paths = [f"{path}\n" for path in photographs_in(survey / "shots")]
    write_plan(survey / "plan.yaml", drafted)
    given = survey / "plan.yaml", survey / "closer.yaml", SearchTargets(False, True)
    answers = list(follow(*given, [*paths, "[]\n"]))
    assert [each["is_last"] for each in answers] == [False, True]
    assert "1 cracks" in answers[-1]["says"]


def test_a_draft_that_cannot_be_completed_is_told_and_stays(survey):
    flying = FlightParameters(endurance=30.0, landing_time=14.0)
    drafted = replace(read_plan(survey / "plan.yaml"), flying=flying, draft=Draft(1, 0.0))
    write_plan(survey / "plan.yaml", drafted)
    (answer,) = follow(survey / "plan.yaml", survey / "closer.yaml", SearchTargets(False, False), ["[]\n"])
    assert (answer["views"], answer["is_last"]) == ([], True)
    assert "too far from home for one battery" in answer["says"]
    assert read_plan(survey / "plan.yaml").draft is not None


def test_a_plan_that_cannot_be_read_is_answered_with_its_sentence(survey):
    search = BackgroundSearch(survey / "nowhere.yaml", survey / "closer.yaml", CRACKS)
    search.ask()
    answer = answered(search)
    assert answer.views == ()
    assert "nowhere.yaml" in answer.says


def test_nobody_waits_while_the_search_is_slow_to_read(survey):
    """A pipe holds 64 kB; the process, stopped here, reads none of them."""
    search = BackgroundSearch(survey / "plan.yaml", survey / "closer.yaml", CRACKS)
    search._process.send_signal(signal.SIGSTOP)
    adding = threading.Thread(
        target=lambda: [search.add(survey / f"{k}.jpg") for k in range(5000)], daemon=True
    )
    adding.start()
    adding.join(20.0)
    assert not adding.is_alive()
    search.close()


def test_a_process_that_dies_is_an_answer(survey):
    search = BackgroundSearch(survey / "plan.yaml", survey / "closer.yaml", CRACKS)
    search._process.kill()
    answer = answered(search)
    assert answer.views == ()
    assert "has ended" in answer.says
    search.add(survey / "late.jpg")  # nobody listens, and nothing is raised


def lives(process):
    """Whether a process of /proc goes on. One that nobody has awaited is listed, too."""
    try:
        return " Z " not in (process / "stat").read_text()
    except OSError:
        return False


def test_the_process_ends_when_its_parent_does(survey):
    """Killed, as a node that dies; else it could write over the plan of the next one."""
    code = (
        "import sys, time\n"
        "from pathlib import Path\n"
        "from inspection.findings.background import BackgroundSearch, SearchTargets\n"
        "search = BackgroundSearch(*map(Path, sys.argv[1:]), SearchTargets())\n"
        "print(search._process.pid, flush=True)\n"
        "time.sleep(600)\n"
    )
    known = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    given = str(survey / "plan.yaml"), str(survey / "closer.yaml")
    parent = subprocess.Popen([sys.executable, "-c", code, *given], stdout=subprocess.PIPE, env=known)
    assert parent.stdout is not None
    child = Path("/proc") / parent.stdout.readline().decode().strip()
    held = os.open(child / "fd" / "0", os.O_WRONLY)  # its input stays open
    parent.kill()
    parent.wait()
    until = time.monotonic() + 60.0
    while lives(child) and time.monotonic() < until:
        time.sleep(0.05)
    os.close(held)
    parent.stdout.close()
    assert not lives(child)


def test_nobody_asks_and_nothing_is_answered(survey):
    paths = [f"{path}\n" for path in photographs_in(survey / "shots")]
    assert not list(follow(survey / "plan.yaml", survey / "closer.yaml", CRACKS, paths))
    assert not (survey / "closer.yaml").exists()


def test_a_damaged_photograph_is_left_out_and_told(survey):
    (path,) = photographs_in(survey / "shots")
    path.write_bytes(path.read_bytes()[:5000])
    (answer,) = follow(survey / "plan.yaml", survey / "closer.yaml", CRACKS, [f"{path}\n", "[]\n"])
    assert answer["views"] == []
    assert "1 photographs are damaged" in answer["says"]


def test_what_was_searched_is_remembered_until_something_changes(survey, monkeypatch):
    searched = []

    def counted(*given):
        searched.append(1)
        return original(*given)

    original = searching.candidates_in
    monkeypatch.setattr(searching, "candidates_in", counted)
    given = [survey / "shots"], survey / "room.stl"
    first = find(*given, FindingParameters())
    assert find(*given, FindingParameters()) == first
    assert len(searched) == 1
    # When a limit, the pose or the mesh is another one, then it is searched again
    find(*given, FindingParameters(crack_contrast=0.2))
    record = survey / "shots" / "0.000000.json"
    record.write_text(record.read_text().replace("0.8,", "0.81,"))
    find(*given, FindingParameters(crack_contrast=0.2))
    room = trimesh.load(survey / "room.stl")
    room.apply_translation((0.01, 0.0, 0.0))
    room.export(survey / "room.stl")
    find(*given, FindingParameters(crack_contrast=0.2))
    assert len(searched) == 4
    # When the file is cut, then it is searched again
    (kept,) = (survey / "shots").glob("*.candidates.npz")
    kept.write_bytes(kept.read_bytes()[:100])
    find(*given, FindingParameters(crack_contrast=0.2))
    assert len(searched) == 5


def test_an_empty_folder_is_refused(tmp_path):
    with pytest.raises(SurveyError, match="no photograph"):
        find([tmp_path], tmp_path / "no.stl", FindingParameters())
