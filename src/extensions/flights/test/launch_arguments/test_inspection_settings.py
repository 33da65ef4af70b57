"""The file of settings of an inspection: what it may say, and that the shipped one says the defaults."""

from __future__ import annotations

from pathlib import Path

import pytest

from flights.errors import FlightError
from simulation_tools.errors import SimulationToolsError

inspection_settings = pytest.importorskip(
    "flights_ros.launch.inspection_settings", reason="needs the workspace's environment"
)
SHIPPED = Path(__file__).resolve().parents[2] / "config/inspecting.yaml"


def written(tmp_path, text):
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_flight_gets_the_camera_of_the_shipped_file():
    found = inspection_settings.read_file(SHIPPED)
    assert (found["width"], found["height"], found["field_of_view"]) == (5184, 3888, 60.0)
    assert (found["exposure"], found["search"], found["swaps"]) == (0.00025, 20.0, 8)


def test_a_file_may_say_little_and_nothing(tmp_path):
    assert inspection_settings.read_file(written(tmp_path, "")) == {}
    assert inspection_settings.read_file(written(tmp_path, "experiment: {draft: false}")) == {"draft": False}


@pytest.mark.table(
    ("text", "sentence"),
    [
        ("experimant: {search: 5}", "There is no parameter experimant; did you mean experiment?"),
        ("experiment: {serch: 5}", "experiment: There is no parameter serch; did you mean search?"),
        ("experiment: {time: 5}", "experiment: There is no parameter time;"),  # has an argument
        ("camera: 5184", "camera holds no names with values;"),
        ("camera: {width: 640}", "width is 640 for the camera and None for the flight; keep the line '<<:"),
        ("a: [", "line 1, column 5 is not YAML"),
    ],
)
def test_what_has_no_effect_is_refused_in_one_sentence(tmp_path, text, sentence):
    with pytest.raises(FlightError) as refused:
        inspection_settings.read_file(written(tmp_path, text))
    assert sentence in str(refused.value)
    assert "mine.yaml" in str(refused.value)


def test_lockstep_needs_a_time(tmp_path):
    with pytest.raises(SimulationToolsError, match=r"lockstep_timeout must be a number from 0\.001"):
        inspection_settings.read_file(written(tmp_path, "gazebo: {lockstep_timeout: 0}"))
