"""The page before the flight tells flights, energy and what cannot be photographed, and prints."""

import shutil
import subprocess
from dataclasses import replace

import pytest
import yaml
from drawn_inspection import SHIP, mesh, ship
from page_words import words

from flight_basics.errors import ReportError
from inspection.camera.survey_camera import SurveyCamera
from inspection.report.command import main
from inspection.report.plan_page import flight_rows, write_plan_page
from inspection.survey.parameters import FlightParameters, SurveyParameters
from inspection.survey.plan import Draft, Flight, Leftover, PlannedView, SurveyPlan
from inspection.survey.plan_file import write_plan
from inspection.survey.views.candidates import View

BROWSER = shutil.which("chromium-headless-shell") or shutil.which("chromium")
VIEWS = tuple(PlannedView(View((0.5 * k, 0.0, 1.0), 1.57, 0.0)) for k in range(3))
FLYING = FlightParameters(battery=50.0, endurance=500.0)
PLAN = SurveyPlan(
    "box.stl", (0.0, 0.0, 1.0), SurveyCamera(800, 600, 60.0), SurveyParameters(radius=0.2, voxel=0.1), FLYING,
    (Flight(VIEWS[:2], 250.0, 30.0), Flight(VIEWS[2:], 100.0, 12.0)),
    {"share": 0.984, "reachable_m2": 40.0}, {"geometry_0": 0.984},
    (Leftover("deep_corner", "no room for the UAV", 1.5, (1.0, 1.5, 0.5)),
     Leftover("deep_corner", "no room for the UAV", 0.5, (0.0, 1.5, 0.5))),
)  # fmt: skip


def test_a_flight_takes_the_energy_of_its_time_in_the_air():
    first, second = flight_rows(PLAN, ship())
    assert (first["photographs"], first["numbers"], second["numbers"]) == (2, "1 to 2", "3")
    assert first["battery"] == pytest.approx(250.0 / 500.0)
    assert first["energy_wh"] == pytest.approx(25.0)
    assert second["energy_wh"] == pytest.approx(10.0)


def test_the_page_tells_flights_and_what_is_left_out(tmp_path):
    write_plan_page(tmp_path / "plan.html", PLAN, None, ship())
    text = words(tmp_path / "plan.html")
    assert "Photographs 3 in 2 flights" in text
    assert "98.4 % of 40 m² within reach" in text
    assert "35 Wh batteries of 50 Wh" in text
    assert "deep corner no room for the UAV 2.0" in text  # both together
    assert ship().describe((1.0, 1.5, 0.5)) in text  # where the larger one is
    assert "there is no picture" in text


def test_shares_are_told_beside_the_whole_drawing_and_the_other_rooms(tmp_path):
    chosen = {"mesh_m2": 501.0, "room_m3": 24.0, "other_rooms": 2.0, "largest_other_room_m3": 210.0}
    write_plan_page(tmp_path / "plan.html", replace(PLAN, figures={**PLAN.figures, **chosen}), None, ship())
    text = words(tmp_path / "plan.html")
    assert "98.4 % of 40 m² within reach; the drawing has 501 m²" in text
    assert "24 m³ in which the UAV fits; 2 other rooms, the largest of 210 m³; --home" in text


def test_what_is_not_surveyed_has_no_share_to_be_seen(tmp_path):
    """What an explored map does not know is no surface: its share would be 100 % of nothing."""
    mapped = replace(PLAN, shares={"mapped_plating": 0.98, "unknown": 1.0})
    write_plan_page(tmp_path / "plan.html", mapped, None, ship())
    text = words(tmp_path / "plan.html")
    assert "plating 98.0 %" in text
    assert "not surveyed" not in text


def test_a_plan_without_figures_or_leftovers_has_a_page_too(tmp_path):
    edited = replace(PLAN, figures={}, shares={}, leftovers=(), flights=())
    write_plan_page(tmp_path / "plan.html", edited, None)
    text = words(tmp_path / "plan.html")
    assert "not computed" in text
    assert "All of the surface within the space can be photographed." in text


def test_the_page_of_a_draft_tells_nothing_that_is_not_known_yet(tmp_path):
    draft = replace(PLAN, figures={"photographs": 3.0}, shares={}, leftovers=(), draft=Draft(1, 20.0))
    write_plan_page(tmp_path / "plan.html", draft, None)
    text = words(tmp_path / "plan.html")
    assert "more are planned during it" in text
    assert "Cannot be photographed \N{EN DASH} not known yet" in text
    assert "can be photographed." not in text


def test_a_page_that_cannot_be_written_is_one_sentence(tmp_path):
    with pytest.raises(ReportError, match="cannot be written"):
        write_plan_page(tmp_path / "no" / "plan.html", PLAN, None)


def test_the_command_draws_the_picture_and_the_page_prints(tmp_path, capsys):
    source = mesh(tmp_path / "box.stl")
    (tmp_path / "ship.yaml").write_text(yaml.safe_dump(SHIP))
    write_plan(tmp_path / "plan.yaml", replace(PLAN, source=str(source)))
    page = tmp_path / "plan.html"
    assert main([str(tmp_path / "plan.yaml"), "--ship", str(tmp_path / "ship.yaml")]) == 0
    assert f"written: {page}" in capsys.readouterr().out
    assert "data:image/png;base64," in page.read_text()
    assert "Fr." in words(page)
    if BROWSER is None:
        pytest.skip("no chromium is installed (apt-get install chromium-headless-shell)")
    command = [BROWSER, "--headless", "--no-sandbox", f"--user-data-dir={tmp_path / 'profile'}"]
    command += [f"--print-to-pdf={tmp_path / 'plan.pdf'}", f"file://{page}"]
    subprocess.run(command, capture_output=True, timeout=200.0, check=True)
    printed = (tmp_path / "plan.pdf").read_bytes()
    assert printed.startswith(b"%PDF")
    assert len(printed) < 2e6
