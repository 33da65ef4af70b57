"""The page of a draft's plan is written once, when the plan is complete."""

import threading
from dataclasses import replace

import pytest

from flights.inspecting import whole_plan
from flights.inspecting.whole_plan import WholePlanPage
from inspection.camera.survey_camera import SurveyCamera
from inspection.survey.parameters import FlightParameters, SurveyParameters
from inspection.survey.plan import Draft, Flight, PlannedView, SurveyPlan
from inspection.survey.plan_file import write_plan
from inspection.survey.views.candidates import View

WAIT_S = 60.0
VIEW = PlannedView(View((1.0, 2.0, 1.5), 0.0, 0.0))
WHOLE = SurveyPlan(
    "hold.stl", (0.0, 0.0, 1.5), SurveyCamera(), SurveyParameters(), FlightParameters(),
    (Flight((VIEW,), 60.0, 10.0),), {"photographs": 1.0}, {},
)  # fmt: skip
DRAFT = replace(WHOLE, draft=Draft(1, 20.0))


@pytest.fixture
def watched(tmp_path, monkeypatch):
    """A draft's file that is watched, and an event for each page."""
    monkeypatch.setattr(whole_plan, "LOOK_S", 0.01)
    path, has_page, pages = tmp_path / "plan.yaml", threading.Event(), []

    def write_page():
        pages.append(path.read_text())
        has_page.set()
        return True

    write_plan(path, DRAFT)
    page = WholePlanPage(path, write_page)
    page.watch()
    yield path, page, has_page, pages
    page.end()


def test_the_page_is_written_in_flight_when_the_plan_is_complete(watched):
    path, page, has_page, pages = watched
    assert not has_page.wait(0.2)
    write_plan(path, WHOLE)
    assert has_page.wait(WAIT_S)
    assert page.end()
    assert len(pages) == 1
    assert "draft" not in pages[0]


def test_a_plan_that_stays_a_draft_has_no_page(watched):
    _, page, _, pages = watched
    assert not page.end()
    assert not pages


def test_a_damaged_plan_has_no_page(watched):
    path, page, has_page, _ = watched
    path.write_text("flights: [")
    assert not has_page.wait(0.3)
    assert not page.end()


def test_what_is_not_watched_ends(tmp_path):
    assert not WholePlanPage(tmp_path / "plan.yaml", lambda: True).end()
