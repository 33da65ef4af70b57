"""Given an inspection's folder, the page tells what is in it and what is missing."""

import io
import json
import math
import re
import shutil
import subprocess
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from drawn_inspection import CAMERA, folder, mesh, side_walls
from page_words import words
from PIL import Image

from inspection.camera.survey_camera import SurveyCamera
from inspection.findings.findings_file import read_search, write_findings
from inspection.findings.picture.flaws import BLURRED
from inspection.photographs.listing import LeftOut
from inspection.photographs.record import PhotographRecord
from inspection.photographs.searched import digest_of
from inspection.report import pictures
from inspection.report.command import main
from inspection.report.page import libraries
from inspection.report.scene import SEEN, scene_of
from inspection.report.sources import Shot, read_inspection
from inspection.report.views import Mark
from inspection.survey.parameters import FlightParameters, SurveyParameters
from inspection.survey.plan import Flight, PlannedView, SurveyPlan
from inspection.survey.plan_file import write_plan
from inspection.survey.surface.mesh_file import read_mesh
from inspection.survey.surface_record import read_surface_record, write_surface_record
from inspection.survey.views.candidates import View

BROWSER = shutil.which("chromium-headless-shell") or shutil.which("chromium")


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """A report with everything: a ship, a last survey and readings of thickness."""
    path = folder(tmp_path_factory.mktemp("inspection"))
    last = folder(tmp_path_factory.mktemp("last"))
    (path / "readings.csv").write_text("frame,strake,side,original_mm,forward_mm,aft_mm\n5,B,P,12,10,11\n")
    options = ["--mesh", mesh(path / "box.stl"), "--ship", path / "ship.yaml", "--last", last]
    options += ["--thickness", path / "readings.csv"]
    assert main([str(path), *map(str, options)]) == 0
    return path / "report.html"


def test_the_page_tells_positions_grades_and_readings(page):
    told = words(page)
    for each in (
        "Fr. 5, strake B, P", "1,000 cm², 50 cm long", "Fr. 4 to 8, strake B, P", "GOOD", "not graded",
        "side plating", "1 graded area; 1 not graded",
        "<b>long</b>", "as before", "rust on 15 % or more", "50.0 %", "2 flights as flown", "40 %", "16.7 %",
        "1,234 m³ of the space were mapped in flight, in 1.5 min", "stays unknown: 1.5 m²: too narrow",
    ):  # fmt: skip
        assert each in told, each


def test_the_page_needs_no_other_file_but_the_originals(page):
    text = re.sub(r"<script>.*?</script>", "", page.read_text(encoding="utf-8"), flags=re.S)
    named = re.findall(r'(?:src|href)="([^"#][^"]*)"', text)
    files = [each for each in named if not each.startswith("data:")]
    assert files
    assert all((page.parent / each).is_file() for each in files)


def test_a_plain_folder_of_photographs_gives_a_page_that_names_what_is_missing(tmp_path):
    path = folder(tmp_path / "all") / "photographs"
    assert main([str(path)]) == 0
    told = words(path / "report.html")
    for each in ("not searched for rust", "There is no survey plan", "no record of the flights", "no grades"):
        assert each in told, each


@pytest.mark.table(
    ("name", "told"), [("coverage.npz", "is no record of a surface"), ("findings.json", "is not JSON")]
)
def test_a_damaged_record_is_told_on_the_page(tmp_path, name, told):
    path = folder(tmp_path / "all")
    (path / name).write_text("cut")
    assert main([str(path)]) == 0
    assert told in words(path / "report.html")


@pytest.mark.table(
    ("name", "key", "value", "told"),
    [
        (
            "result.json",
            "exploration",
            {"known_m3": 5.0, "unknown": [{"border_m2": 1.0}]},
            "lacks the key 'why'",
        ),
        ("result.json", "flights", [{"time_s": "long"}, 5], "time_s in entry 1 of flights is 'long'"),
        ("result.json", "versions", ["numpy"], "versions is ['numpy']; it must be a mapping."),
        ("coverage.json", "share_of_reachable", "most", "share_of_reachable is 'most'"),
        ("coverage.json", "counted", 3, "counted is 3; it must be a list."),
    ],
)
def test_what_was_altered_in_a_record_is_left_out_and_told(tmp_path, name, key, value, told):
    path = folder(tmp_path / "all")
    record = json.loads((path / name).read_text())
    (path / name).write_text(json.dumps(record | {key: value}))
    assert main([str(path)]) == 0
    page = words(path / "report.html")
    assert told in page
    assert "left out" in page


def test_a_surface_whose_columns_do_not_fit_is_told(tmp_path):
    path = folder(tmp_path / "all")
    with np.load(path / "coverage.npz") as held:
        np.savez(path / "altered.npz", **{**held, "parts": held["parts"] + 1000})
    (path / "altered.npz").rename(path / "coverage.npz")
    assert main([str(path)]) == 0
    assert "its columns do not fit each other" in words(path / "report.html")


def test_what_the_findings_rest_on_is_told_and_without_it_nothing_is_graded(tmp_path):
    path = folder(tmp_path)
    shots = sorted((path / "photographs").glob("*.jpg"))
    rests_on = {each.name: digest_of(each) for each in shots}
    blurred = tuple(LeftOut(each.name, BLURRED) for each in shots)
    file, report = path / "findings.json", [str(path), "--mesh", str(mesh(path / "box.stl"))]
    write_findings(file, replace(read_search(file), rests_on=rests_on, flawed=blurred))
    assert main(report) == 0
    told = words(path / "report.html")
    assert "GOOD" in told
    assert "blurred" in told
    record = json.loads(shots[1].with_suffix(".json").read_text())
    record["position_m"][0] += 1.0
    shots[1].with_suffix(".json").write_text(json.dumps(record))
    assert main(report) == 0
    told = words(path / "report.html")
    assert shots[1].name in told
    assert "Run findings again" in told
    write_findings(file, replace(read_search(file), rests_on={each.name: digest_of(each) for each in shots}))
    coverage = json.loads((path / "coverage.json").read_text())
    (path / "coverage.json").write_text(json.dumps(coverage | {"rests_on": rests_on}))
    assert main(report) == 0
    told = words(path / "report.html")
    assert "Run survey_planner coverage again" in told
    assert "GOOD" not in told.partition("Coating condition")[2].partition("GOOD:")[0]


def test_a_photograph_that_came_after_the_search_is_told(tmp_path):
    path = folder(tmp_path)
    shot = min((path / "photographs").glob("*.jpg"))
    before = read_search(path / "findings.json")
    for names, is_told in (((shot.name,), False), (("1.jpg",), True)):
        write_findings(path / "findings.json", replace(before, searched=names))
        assert main([str(path)]) == 0
        assert (f"({shot.name}" in words(path / "report.html")) is is_told


def test_photographs_of_another_size_than_the_plans_are_told(tmp_path):
    path = folder(tmp_path)
    view = View((0.0, -1.0, 1.0), math.pi / 2, 0.0)
    for camera, is_told in ((CAMERA, False), (SurveyCamera(320, 240, CAMERA.field_of_view), True)):
        flight = Flight((PlannedView(view),), 60.0, 5.0)
        asked, flying = SurveyParameters(), FlightParameters()
        write_plan(path / "plan.yaml", SurveyPlan("box.stl", (0.0,) * 3, camera, asked, flying, (flight,)))
        assert any("320 x 240 px" in each for each in read_inspection(path).remarks) == is_told


def test_a_contact_is_told_in_words_of_surveyors(tmp_path):
    path = folder(tmp_path / "all")
    result = json.loads((path / "result.json").read_text())
    part = "beams::link::web_port_07"
    result |= {"touched": [part], "failure": f"The UAV touched {part}."}
    (path / "result.json").write_text(json.dumps(result))
    assert main([str(path)]) == 0
    told = words(path / "report.html")
    assert "The aircraft touched the structure in flight: web port 07." in told
    assert "::" not in told
    (path / "result.json").write_text(json.dumps(result | {"failure": "The UAV did not come home."}))
    assert main([str(path)]) == 0
    told = words(path / "report.html")
    assert "touched the structure in flight: web port 07." in told
    assert "The UAV did not come home." in told


def test_no_folder_no_photographs_and_no_ship_are_one_sentence_each(tmp_path, capsys):
    wrong = (
        [str(tmp_path / "none")],
        [str(tmp_path)],
        [str(folder(tmp_path / "all")), "--ship", "none.yaml"],
    )
    for arguments in wrong:
        assert main(arguments) == 1
        assert capsys.readouterr().err.count("\n") == 1


def test_the_scene_shows_the_sides_in_the_air_with_their_area_and_state(tmp_path):
    surface = side_walls(lambda points: points[:, 0] > 0.0)
    scene = scene_of(read_mesh(mesh(tmp_path / "box.stl")), surface)
    edges = scene.triangles_m[:, 1:] - scene.triangles_m[:, :1]
    areas = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    assert areas.sum() == 16.0
    assert areas[scene.states == SEEN].sum() == pytest.approx(8.0, abs=0.5)
    # and its twelve edges, of 4, 3 and 2 m
    lengths = np.linalg.norm(scene.edges_m[:, 1] - scene.edges_m[:, 0], axis=1)
    assert sorted(np.round(lengths, 6).tolist()) == [2.0] * 4 + [3.0] * 4 + [4.0] * 4


def test_a_surface_record_comes_back_as_it_was(tmp_path):
    record = side_walls(lambda points: points[:, 0] > 0.0)
    write_surface_record(tmp_path / "a.npz", record)
    back = read_surface_record(tmp_path / "a.npz")
    assert back.names == record.names
    assert np.array_equal(back.shown, record.shown)
    assert np.allclose(back.points_m, record.points_m)
    assert np.allclose(back.normals, record.normals)


def noise(number):
    rng = np.random.default_rng(number)
    return Image.fromarray(rng.integers(0, 255, (90, 120, 3)).astype(np.uint8))


def test_many_pictures_are_made_coarser_until_they_fit_and_no_more_are_taken_then():
    levels = ((120, 80), (60, 60), (30, 40))
    told = []
    for budget in (10**6, 15_000, 2_000, 1):
        sheet = pictures.Sheet(levels, budget)
        for number in range(6):
            sheet.add(number, noise(number))
        widths = {Image.open(io.BytesIO(each)).width for each in sheet.pictures.values()}
        told.append((len(sheet.pictures), *widths))
        assert sum(map(len, sheet.pictures.values())) <= budget
        assert sheet.is_full == (len(sheet.pictures) < 6)
    assert told[:2] == [(6, 120), (6, 60)]
    assert told[2][1:] == (30,)
    assert 0 < told[2][0] < 6
    assert told[3] == (0,)


def test_photographs_without_a_small_picture_are_told_and_those_with_findings_come_first(
    tmp_path, monkeypatch
):
    path = folder(tmp_path)
    names = [each.name for each in (path / "photographs").glob("*.jpg")]
    monkeypatch.setattr(pictures.Sheet.__init__, "__defaults__", (2_500,))
    assert main([str(path), "--mesh", str(mesh(path / "box.stl"))]) == 0
    told = words(path / "report.html")
    assert "1 of 2 photographs have no small picture here" in told
    page = (path / "report.html").read_text()
    assert all(f'href="photographs/{name}"' in page for name in names)


def test_many_photographs_take_the_memory_of_their_small_pictures(tmp_path):
    """1.5 MB each would be 150 MB."""
    picture = tmp_path / "1.jpg"
    Image.fromarray(np.random.default_rng(1).integers(90, 160, (486, 648, 3)).astype(np.uint8)).save(picture)
    record = PhotographRecord(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    shots = [Shot(picture, record)] * 100
    tracemalloc.start()
    small = pictures.small_pictures(shots, {})
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(small.thumbs) > 60
    assert peak < 30e6


CLICKS = """<script>
const count = (query) => document.querySelectorAll(query).length;
document.querySelector('#finding-2 [data-show-finding]').click();
const byTable = [panel.dataset.finding, panel.dataset.photograph, count('#photo-frame img')];
document.querySelectorAll('#photo-frame .mark')[0].click();
const byMark = panel.dataset.finding;
const view = window.inspection.view;
let inView = null;
if (view) {
  const [clientX, clientY] = view.screen(window.inspection.data.findings[1].at);
  for (const kind of ['pointerdown', 'pointerup'])
    view.canvas.dispatchEvent(new PointerEvent(kind, {clientX, clientY, pointerId: 1}));
  inView = panel.dataset.finding;
}
for (const each of document.querySelectorAll('[data-thumb] img')) each.remove();
document.querySelector('#finding-2 [data-show-finding]').click();
const original = document.querySelector('#photo-frame img');
document.body.dataset.clicked = JSON.stringify([byTable, byMark, inView, original && original.src]);
</script>"""


HEADLESS = ("--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


@pytest.mark.skipif(
    BROWSER is None, reason="no chromium is installed (apt-get install chromium-headless-shell)"
)
def test_a_browser_shows_the_photograph_of_a_finding_that_is_clicked(page, tmp_path):
    text = page.read_text(encoding="utf-8")
    clicked_page = page.with_name("clicked.html")  # beside its photographs
    clicked_page.write_text(text.replace("</body>", CLICKS + "</body>"), encoding="utf-8")
    command = [
        BROWSER,
        *HEADLESS,
        "--enable-logging=stderr",
        "--dump-dom",
        f"--user-data-dir={tmp_path / 'profile'}",
    ]
    done = subprocess.run([*command, f"file://{clicked_page}"], capture_output=True, text=True, timeout=200.0)
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line and "GL Driver" not in line]
    assert not console
    clicked = re.search(r'data-clicked="([^"]*)"', done.stdout)
    assert clicked, done.stderr[-2000:]
    by_table, by_mark, in_view, original = json.loads(clicked[1].replace("&quot;", '"'))
    assert by_table == ["2", "1", 1] or by_table == ["2", "0", 1]
    assert by_mark in ("1", "2")
    assert original == (page.parent / "photographs" / f"{by_table[1]}.000000.jpg").as_uri()
    if libraries() and "with-3d" in done.stdout:
        assert in_view == "2"


FRAMES = """<body style="margin: 0">
<iframe src="page.html" width="390" height="844"></iframe>
<iframe src="page.html" width="1000" height="800"></iframe>
<script>
const frames = [...document.querySelectorAll("iframe")];
const inside = (frame) => frame.contentDocument.scrollingElement;
window.onload = () => {
  const widths = frames.map((each) => [inside(each).scrollWidth, inside(each).clientWidth]);
  const own = frames[0].contentWindow.inspection.view;
  frames[1].width = 390;
  const resized = frames[1].contentWindow.inspection.view;
  setTimeout(() => {
    const away = (view) => view.camera.position.distanceTo(view.controls.target);
    document.body.dataset.told = JSON.stringify([widths, own ? [away(own), away(resized)] : []]);
  }, 300);
};
</script>"""


@pytest.mark.skipif(
    BROWSER is None, reason="no chromium is installed (apt-get install chromium-headless-shell)"
)
def test_the_page_is_as_wide_as_its_window_and_the_view_stays_whole_in_a_narrower_one(page, tmp_path):
    """What is wider, such as a table, moves by itself. A headless window has 500 px at least, a frame not."""
    shutil.copy(page, tmp_path / "page.html")
    (tmp_path / "frames.html").write_text(FRAMES)
    command = [
        BROWSER,
        *HEADLESS,
        "--allow-file-access-from-files",
        "--virtual-time-budget=9000",
        "--dump-dom",
    ]
    done = subprocess.run(
        [*command, f"--user-data-dir={tmp_path / 'profile'}", f"file://{tmp_path}/frames.html"],
        capture_output=True, text=True, timeout=200,
    )  # fmt: skip
    told = re.search(r'data-told="([^"]*)"', done.stdout)
    assert told, done.stderr[-2000:]
    widths, away_m = json.loads(told[1])
    assert [whole <= window <= asked for (whole, window), asked in zip(widths, (390, 1000))] == [True, True]
    if away_m:
        assert away_m[1] == pytest.approx(away_m[0], rel=0.01)


def test_particulars_that_nobody_gave_say_so(page):
    told = words(page)
    assert "IMO number 9074729" in told
    assert "Surveyor A. Inspector" in told
    assert "Pilot not given" in told


@pytest.mark.table(
    ("per_m", "length_m", "told"),
    [
        (1000.0, 0.1, "100 mm"),
        (290.0, 0.2, "200 mm"),
        (100.0, 1.0, "1 m"),
        (5e4, 0.002, "2 mm"),
        (1e6, 0.001, "1 mm"),
    ],
)
def test_a_scale_bar_has_the_longest_usual_length_that_fits(per_m, length_m, told):
    assert pictures.bar_of(per_m, 144.0) == (length_m, told)


def test_a_cut_out_tells_its_scale():
    """20 cm in a photograph of 1000 px, of which a metre takes half: the cut-out's 360 px are 0.48 m."""
    whole = Image.new("RGB", (1000, 800), (120, 120, 120))
    mark = Mark(1, 0, (0.5, 0.5), 0.05, 1.0, 0.5)
    cut = np.array(pictures._cut_out(whole, mark).convert("L"), int)
    row = cut[pictures.CUT_OUT_PX - 14]
    bar = np.flatnonzero(row > 230)
    assert np.ptp(bar) == pytest.approx(
        0.1 * 500 * 360 / 240, abs=3
    )  # 100 mm; 200 mm would be more than 144 px
