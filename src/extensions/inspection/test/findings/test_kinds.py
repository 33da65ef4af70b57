"""A kind of finding is one object; what is joined, measured, graded and told follows from it."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_inspection import finding, ship, side_walls

from inspection.findings import kinds
from inspection.findings.kinds import CRACK, FINDING_KINDS, RUST, kind_of, kinds_of
from inspection.findings.merging import merged
from inspection.findings.parameters import FindingParameters
from inspection.findings.placing import Placed
from inspection.report import grades
from inspection.report.comparison import AS_BEFORE, GROWN, Survey, compared
from inspection.report.grades import GradeRules, areas_graded, plates_seen
from inspection.report.tables import size_of

FLAKE = replace(RUST, name="flake", word="flake", plural="flakes", heading="Flakes")
BUMP = replace(FLAKE, name="bump", word="bump", is_sized_by_area=False, counts_for_coating=False)
SEAM = replace(CRACK, name="seam", word="seam", plural="seams", heading="Seams")
OWN = (FLAKE, BUMP, SEAM)


@pytest.fixture(autouse=True)
def kinds_of_one_s_own(monkeypatch):
    for module in (kinds, grades):
        monkeypatch.setattr(module, "FINDING_KINDS", (*FINDING_KINDS, *OWN))


def graded(*findings):
    """Return the grade of the port wall, of 8 m2, all of it seen."""
    walls = side_walls(lambda points: points[:, 1] > 0)
    return areas_graded(ship(), walls, np.zeros((0, 3)), findings, GradeRules())[0]


@pytest.mark.table(
    ("kind", "share"), [("rust", 0.1), ("flake", 0.1), ("bump", 0.0), ("crack", 0.0), ("unheard of", 0.0)]
)
def test_the_area_is_rusted_if_the_kind_says_so(kind, share):
    mark = finding(1, kind, (0.5, 1.5, 1.2), 0.5, 0.8)
    assert graded(mark).rust_share == pytest.approx(share)
    rusted_m2 = sum(each.rust_m2 for each in plates_seen(ship(), side_walls(lambda p: p[:, 1] > 0), [mark]))
    assert rusted_m2 == pytest.approx(8.0 * share)


def test_each_kind_is_counted_in_its_column():
    marks = [finding(k, kind, (0.5, 1.5, 1.2), 0.5, 0.1) for k, kind in enumerate(("seam", "rust", "seam"))]
    assert dict(zip((kind.name for kind in kinds.FINDING_KINDS), graded(*marks).numbers)) == {
        "rust": 1, "crack": 0, "flake": 0, "bump": 0, "seam": 2,
    }  # fmt: skip


def test_a_long_line_is_one_finding_and_a_long_spot_comes_in_pieces():
    along = np.array([(x, 0.0, 0.0) for x in np.arange(0.0, 6.0, 0.02)])
    long = {
        kind: len(merged([Placed(kind, along, np.array((0.0, 0.0, 1.0)), 0.3, "1.jpg", 1.0, along[0])], 0.1))
        for kind in ("crack", "seam", "rust", "bump")
    }
    assert (long["crack"], long["seam"]) == (1, 1)
    assert long["rust"] == long["bump"] > 1


def test_size_is_an_area_or_a_length():
    assert size_of(finding(1, "flake", (0, 0, 0), 0.5, 0.02)) == "200 cm², 50 cm long"
    assert size_of(finding(1, "bump", (0, 0, 0), 0.5, 0.02)) == "500 mm long"
    least = FindingParameters(crack_length=0.06, rust_size=0.02)
    assert kind_of("seam").is_large_enough(0.06, 0.0, least)
    assert not kind_of("seam").is_large_enough(0.05, 1.0, least)
    assert kind_of("bump").is_large_enough(0.0, 4.1e-4, least)
    assert not kind_of("bump").is_large_enough(1.0, 3.9e-4, least)


@pytest.mark.table(("kind", "wider"), [("flake", GROWN), ("bump", AS_BEFORE)])
def test_growth_is_of_what_the_size_is(kind, wider):
    before, now = (finding(1, kind, (0.5, 1.5, 1.2), 0.5, area_m2) for area_m2 in (0.02, 0.05))
    assert compared(Survey([before], None), Survey([now], None)).change[1] == wider


def test_kinds_that_nobody_has_written_come_after_those_that_are_known():
    assert [kind.name for kind in kinds_of(["weld", "rust", "ant"])][-2:] == ["ant", "weld"]
    assert kind_of("ant").word == "ant"
    assert kind_of("rust").page_colour_hex == "#9b3a18"
