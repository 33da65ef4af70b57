"""A flight that takes many minutes on a busy machine says how far it is."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

rospy = pytest.importorskip("rospy", reason="needs the workspace's environment")
progress = pytest.importorskip("flights_ros.drivers.progress", reason="needs the workspace's environment")


@pytest.mark.parametrize(("at_once", "expected"), [(True, [0, 30, 65]), (False, [30, 65])])
def test_lines_are_a_period_apart_in_wall_time(at_once, expected):
    now = {"s": 0}
    pace = progress.Pace(30.0, at_once, lambda: now["s"])
    due = []
    for now["s"] in (0, 1, 29, 30, 59, 65, 94):
        if pace.is_due():
            due.append(now["s"])
    assert due == expected


def test_a_line_leaves_out_what_is_not_known():
    assert progress.in_words("exploring", "40 m3 known", home_way_m=3.2, charge=0.967) == (
        "Exploring: 40 m3 known, 3 m from home, battery 97 %."
    )
    assert progress.in_words("waiting for the map", home_way_m=math.nan) == "Waiting for the map."


@pytest.fixture
def lines(monkeypatch):
    said = []
    monkeypatch.setattr(rospy, "loginfo", lambda text, *words: said.append(text % words))
    monkeypatch.setattr(rospy, "Publisher", lambda *_, **__: None)
    monkeypatch.setattr(progress, "FLIGHT_PERIOD_S", 0.0)
    return said


def test_an_exploration_says_how_far_it_is(lines):
    from exploration.msg import ExploreActionFeedback
    from flights_ros.exploring.part import ExplorationPart

    part, message = ExplorationPart(SimpleNamespace(now_s=13.0), 120.0), ExploreActionFeedback()
    told = message.feedback
    told.phase, told.known, told.home_way, told.charge = "exploring", 40.0, 3.0, math.nan
    part._monitor.now_s = 36.0
    part._on_feedback(message)
    assert lines == ["Exploring: 23 s of simulated time, at most 120 s, 40 m3 known, 3 m from home."]


def test_a_survey_says_how_many_photographs_it_has(lines, tmp_path):
    from flights_ros.inspecting.part import SurveyPart
    from inspection.msg import SurveyActionFeedback

    part, message = SurveyPart(SimpleNamespace(), tmp_path, lambda: None), SurveyActionFeedback()
    told = message.feedback
    told.phase, told.taken, told.of, told.home_way, told.charge = "photographing", 6, 10, 4.0, 0.5
    part._on_feedback(message)
    assert lines == ["Photographing: 6 of 10 photographs are taken, 4 m from home, battery 50 %."]
    assert (f"{part.action}/feedback", SurveyActionFeedback, part._on_feedback) in part.listens


def test_a_search_that_is_awaited_on_the_ground_says_that_it_goes_on(lines, tmp_path, monkeypatch):
    from flights_ros.inspecting import part as module

    part = module.SurveyPart(SimpleNamespace(), tmp_path, lambda: None)
    part._on_search(SimpleNamespace(data="searching"))
    monkeypatch.setattr(module, "WAKE_S", 0.0)

    def say(text, *words):
        lines.append(text % words)
        part._on_search(SimpleNamespace(data="idle"))

    monkeypatch.setattr(rospy, "loginfo", say)
    assert part.wait()
    assert lines == ["Searching the photographs: 0 s so far, rosservice call /inspect/abort ends it."]
