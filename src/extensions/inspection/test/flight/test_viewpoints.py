"""A photograph belongs to a viewpoint by what it was taken for, whatever its number is in a plan."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from inspection.camera.survey_camera import SurveyCamera, optical_axes
from inspection.flight import InspectionParameters
from inspection.flight.photograph_records import done_in
from inspection.flight.viewpoints import Viewpoints, is_completed, row_of
from inspection.photographs.folder import PhotographFolder
from inspection.photographs.record import PhotographRecord
from inspection.survey.parameters import FlightParameters, SurveyParameters
from inspection.survey.plan import Draft, Flight, PlannedView, SurveyPlan
from inspection.survey.plan_file import read_plan, write_plan
from inspection.survey.views.candidates import View

CAMERA = SurveyCamera(64, 48, 60.0)
VIEWS = (View((4.0, 5.0, 2.0), 0.0, 0.0), View((6.0, 4.0, 2.5), 1.5, 0.4), View((4.0, 3.0, 1.5), 3.0, -0.4))
FAR_M = InspectionParameters.far


def record(view, number, off_m=(0.0, 0.0, 0.0), tells=True):
    """A good photograph of a view, taken a little off it. tells: for which viewpoint it was taken."""
    turn = tuple(Rotation.from_matrix(optical_axes(view.yaw_rad, view.tilt_rad)).as_quat().tolist())
    place_m = tuple(np.add(view.place_m, off_m).tolist())
    told = row_of(view) if tells else None
    return PhotographRecord(float(number), place_m, turn, 0.002, 100.0, 100.0, view=number, viewpoint=told)


def done(tmp_path, records, views):
    store = PhotographFolder(tmp_path, CAMERA)
    for each in records:
        store.save(np.zeros((48, 64, 3), np.uint8), each)
    return done_in(tmp_path, InspectionParameters(), views)


@pytest.mark.table("tells", [True, False])
@pytest.mark.table(
    ("edited", "stays"),
    [
        (VIEWS, {1, 2, 3}),
        (VIEWS[1:], {1, 2}),
        (VIEWS[::-1], {1, 2, 3}),
        ((View((1.0, 1.0, 1.0), 0.0, 0.0), *VIEWS), {2, 3, 4}),
        ((replace(VIEWS[0], place_m=(4.0, 5.0, 3.0)), *VIEWS[1:]), {2, 3}),
        ((replace(VIEWS[0], yaw_rad=math.pi), *VIEWS[1:]), {2, 3}),
        ((replace(VIEWS[0], tilt_rad=0.5), *VIEWS[1:]), {2, 3}),
        ((replace(VIEWS[0], yaw_rad=2.0 * math.pi), *VIEWS[1:]), {1, 2, 3}),
        ((), set()),
    ],
)
def test_what_an_edited_plan_has_still_is_done_and_what_is_new_is_not(tmp_path, tells, edited, stays):
    records = [record(view, number, tells=tells) for number, view in enumerate(VIEWS, start=1)]
    assert done(tmp_path, records, edited) == stays


def test_a_viewpoint_that_was_moved_a_little_is_new(tmp_path):
    moved = replace(VIEWS[0], place_m=(4.05, 5.0, 2.0))
    assert done(tmp_path, [record(VIEWS[0], 1)], (moved,)) == set()


def test_a_photograph_that_was_taken_off_its_viewpoint_still_belongs_to_it(tmp_path):
    off_m = (2.0 * FAR_M, 0.0, 0.0)
    assert done(tmp_path, [record(VIEWS[0], 1, off_m)], VIEWS) == {1}
    assert Viewpoints(VIEWS, FAR_M).shown_by(record(VIEWS[0], 1, off_m, tells=False)) == set()


def test_a_closer_look_keeps_its_number(tmp_path):
    assert done(tmp_path, [record(VIEWS[0], -2)], VIEWS) == {-2}


def plan_of(views, draft=None):
    asked = SurveyParameters(resolution=20.0)
    flights = (Flight(tuple(map(PlannedView, views)), 60.0, 10.0),)
    return SurveyPlan("room.stl", (2.0, 5.0, 2.0), CAMERA, asked, FlightParameters(), flights, draft=draft)


def test_a_plan_in_a_file_has_the_same_viewpoints(tmp_path):
    exact = [View((1.0 / 3.0, 2.0 / 3.0, 0.1), 1.0 / 3.0, -1.0 / 7.0)]
    write_plan(tmp_path / "plan.yaml", plan_of(exact))
    assert done(tmp_path / "photographs", [record(exact[0], 1)], read_plan(tmp_path / "plan.yaml").views) == {
        1
    }


def test_a_draft_that_was_completed_is_the_same_survey_and_one_that_was_edited_is_not():
    draft, whole = plan_of(VIEWS[:1], Draft(1, 0.0)), plan_of(VIEWS)
    assert is_completed(draft, whole, VIEWS[:1])  # its search has not told the others yet
    assert is_completed(draft, whole, VIEWS)
    assert is_completed(draft, whole, (*VIEWS, VIEWS[0]))  # more were asked for since
    assert not is_completed(draft, draft, VIEWS[:1])
    assert not is_completed(draft, plan_of(VIEWS[1:]), VIEWS[:1])
    assert not is_completed(draft, plan_of((VIEWS[0], VIEWS[2], VIEWS[1])), VIEWS)
    assert not is_completed(draft, replace(whole, home_m=(0.0, 0.0, 0.0)), VIEWS)
    assert not is_completed(whole, whole, VIEWS)
