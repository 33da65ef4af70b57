"""Given photographs that nobody searched, the page grades nothing by them, and says so."""

import json
from dataclasses import replace

import numpy as np
import pytest
from drawn_inspection import finding, folder, mesh, side_walls
from page_words import words

from inspection.findings.findings_file import SearchRecord, read_search, write_findings
from inspection.report.command import main
from inspection.survey.surface_record import surface_record_bytes, write_surface_record


def page_of(path, *more):
    """The words of a report of a folder."""
    given = ["--mesh", mesh(path / "box.stl"), "--ship", path / "ship.yaml", *more]
    assert main([str(path), *map(str, given)]) == 0
    return words(path / "report.html")


def changed(path, **more):
    """The search of a folder, with something else in it."""
    write_findings(path / "findings.json", replace(read_search(path / "findings.json"), **more))


def test_with_all_photographs_searched_there_is_a_grade(tmp_path):
    assert "GOOD" in page_of(folder(tmp_path)).split("Proposed grades")[0]


@pytest.mark.table(
    ("searched", "told"),
    [
        (("0.000000.jpg",), "1 photograph that nobody has searched, the first 1.000000.jpg"),
        (None, "does not tell which"),
    ],
)
def test_a_photograph_that_was_not_searched_grades_nothing(tmp_path, searched, told):
    path = folder(tmp_path)
    changed(path, searched=searched)
    page = page_of(path)
    assert told in page
    assert "There are no grades" in page
    assert "Surface seen \N{EN DASH} not all photographs were searched" in page


def test_a_coverage_of_a_plan_or_of_an_older_program_grades_nothing(tmp_path):
    path = folder(tmp_path)
    record = json.loads((path / "coverage.json").read_text())
    del record["counted"]
    (path / "coverage.json").write_text(json.dumps(record))
    page = page_of(path)
    assert "coverage.json does not tell which photographs it counts" in page
    assert "There are no grades" in page


def test_a_share_of_a_map_is_told_as_one_beside_that_of_the_drawing(tmp_path):
    path = folder(tmp_path)
    record = json.loads((path / "coverage.json").read_text())
    webs = {"reachable_m2": 3.0, "share": 0.5, "not_mapped_m2": 2.5}
    drawing = {"surface": "hull.world", "reachable_m2": 20.0, "share_of_reachable": 0.4, "not_mapped_m2": 2.5}
    record |= {"of": "map", "surface": "drawing.glb", "drawing": {**drawing, "classes": {"webs": webs}}}
    (path / "coverage.json").write_text(json.dumps(record))
    page = page_of(path)
    assert "Surface seen 50.0 % of 16 m² within reach that the flight mapped; 40.0 % of the drawing's" in page
    assert "2.5 m² of it are not on the map" in page
    assert "webs 2.5 m²" in page


def test_two_files_of_two_runs_do_not_pass_for_one_record(tmp_path):
    """A process that is killed between coverage.npz and coverage.json leaves them so."""
    path = folder(tmp_path)
    record = json.loads((path / "coverage.json").read_text())
    (path / "coverage.json").write_text(json.dumps({**record, "record": "0" * 64}))
    page = page_of(path)
    assert "is not of the same run as coverage.json" in page
    assert "There are no grades" in page


def test_a_photograph_that_is_cut_is_named_on_the_page(tmp_path):
    path = folder(tmp_path)
    (path / "photographs" / "1.000000.jpg").write_bytes(b"")
    assert "Left out: 1 photograph (1.000000.jpg). The file is empty" in page_of(path)


def test_a_kind_of_ones_own_is_no_rust(tmp_path):
    path = folder(tmp_path)
    rust = read_search(path / "findings.json").findings
    own = finding(9, "blister", (0.5, 1.5, 0.5), 0.3, 5.0)
    changed(path, findings=(*rust, own))
    assert "Rust 1 0.10 m² in all" in page_of(path)


def test_a_last_survey_without_findings_or_of_another_space_is_refused(tmp_path, capsys):
    path, last = folder(tmp_path / "now"), folder(tmp_path / "last")
    given = [str(path), "--mesh", str(mesh(path / "box.stl")), "--last", str(last)]
    assert main(given) == 0
    (last / "findings.json").unlink()
    assert main(given) == 1
    assert "the last survey has no findings" in capsys.readouterr().err
    write_findings(last / "findings.json", SearchRecord((), ("0.000000.jpg",)))
    foreign = side_walls(lambda points: points[:, 1] > 0.0)
    write_surface_record(
        last / "coverage.npz", replace(foreign, points_m=foreign.points_m + np.array((40.0, 3.0, 0.0)))
    )
    assert main(given) == 1
    assert "of another space" in capsys.readouterr().err
    # Without the record of its surface, its findings tell
    (last / "coverage.npz").unlink()
    far = tuple(finding(k, "rust", (50.0 + k, 1.5, 1.0), 0.2, 0.01) for k in range(1, 8))
    write_findings(last / "findings.json", SearchRecord(far, ("0.000000.jpg",)))
    assert main(given) == 1
    assert "of another space" in capsys.readouterr().err


def test_the_plates_to_gauge_are_those_in_the_table(tmp_path):
    """One plate is rusted, by 5 %: it is among the most rusted ones, and so it is proposed."""
    path = folder(tmp_path)
    page = page_of(path)
    assert "Plates to gauge 1 0 with rust on 15 % or more" in page
    assert page.count("among the most rusted plates") == 1


def test_a_record_has_the_same_bytes_twice():
    """Its digest ties it to coverage.json."""
    record = side_walls(lambda points: points[:, 1] > 0.0)
    assert surface_record_bytes(record) == surface_record_bytes(record)


def test_where_the_coating_is_as_red_as_rust_the_page_says_so_and_grades_nothing(tmp_path):
    path = folder(tmp_path)
    changed(path, red=("0.000000.jpg", "1.000000.jpg"))
    page = page_of(path)
    assert "2 of 2 photographs show little but the colour of rust" in page
    assert "GOOD" not in page.split("Proposed grades")[0]
