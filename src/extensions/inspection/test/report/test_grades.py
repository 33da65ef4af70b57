"""Given rust of known area on walls of known area, grades and plates follow from the rule's figures."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_inspection import FINDINGS, finding, mesh, ship, side_walls

from inspection.findings.findings_file import DISMISSED
from inspection.report.gauging.spots import close_up_spots, gauging_spots
from inspection.report.grades import GradeRules, areas_graded, plates_seen
from inspection.survey.surface.edges import STEP_M, edge_places
from inspection.survey.surface.mesh_file import Mesh, read_mesh

RULES = GradeRules()
NO_EDGES = np.zeros((0, 3))


@pytest.mark.table(
    ("area", "edges", "grade"),
    [
        (0.0, 0.0, "GOOD"), (0.029, 0.199, "GOOD"), (0.03, 0.0, "FAIR"), (0.0, 0.20, "FAIR"),
        (0.20, 0.50, "FAIR"), (0.201, 0.0, "POOR"), (0.0, 0.501, "POOR"), (0.05, 0.6, "POOR"),
    ],
)  # fmt: skip
def test_grades_are_those_of_the_circular(area, edges, grade):
    assert RULES.grade(area, edges) == grade


@pytest.mark.table(
    ("area", "edges", "other"),
    [
        (0.01, 0.1, None), (0.027, 0.1, "FAIR"), (0.01, 0.18, "FAIR"), (0.034, 0.1, "GOOD"),
        (0.05, 0.21, None), (0.19, 0.1, "POOR"), (0.22, 0.1, "FAIR"), (0.4, 0.1, None), (0.05, 0.45, "POOR"),
    ],
)  # fmt: skip
def test_a_share_near_a_limit_tells_the_other_grade_too(area, edges, other):
    """A share may be wrong by 15 % of itself."""
    assert RULES.other_grade(area, edges) == other
    assert GradeRules(error=0.0).other_grade(area, edges) is None


def port_and_starboard(findings, shown, edges=NO_EDGES):
    return areas_graded(ship(), side_walls(shown), edges, findings, RULES)


def test_the_rusted_share_is_of_what_was_seen():
    findings = [finding(1, "rust", (0.5, 1.5, 1.2), 0.5, 0.6), finding(2, "rust", (0.5, -1.5, 1.2), 0.2, 0.1)]
    port, starboard = port_and_starboard(findings, lambda points: (points[:, 1] < 0) | (points[:, 0] > -1.0))
    assert (port.area_m2, port.seen_m2, port.rust_share) == pytest.approx((8.0, 6.0, 0.1))
    assert (port.grade, starboard.grade, starboard.rust_share) == ("FAIR", "GOOD", pytest.approx(0.0125))


def test_what_was_seen_too_little_or_dismissed_does_not_count():
    rust = finding(1, "rust", (0.5, 1.5, 1.2), 0.5, 5.0, status=DISMISSED)
    port, starboard = port_and_starboard([rust], lambda points: (points[:, 1] > 0) | (points[:, 0] > 1.0))
    assert (port.grade, port.rust_share, starboard.grade) == ("GOOD", 0.0, None)


def test_edges_of_a_box_have_its_length_and_rust_on_them_counts(tmp_path):
    box = read_mesh(mesh(tmp_path / "box.stl"))
    edges = edge_places(box.triangles_m, box.part)
    assert STEP_M * len(edges) == pytest.approx(4 * (4.0 + 3.0 + 2.0), abs=0.5)
    # the port wall has 12 m of edges; those at its corners belong to both walls' ends
    rust = finding(1, "rust", (0.0, 1.5, 0.0), 1.0, 0.01)
    port, _ = port_and_starboard([rust], lambda points: points[:, 1] > 0, edges)
    assert port.edges_m == pytest.approx(12.0, abs=0.9)
    assert port.edge_share * port.edges_m == pytest.approx(1.0, abs=2 * STEP_M)


def test_where_a_maps_plating_becomes_structure_in_one_plane_there_is_no_edge():
    square = np.array(((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)))
    halves = [
        square[[0, 1, 2]],
        square[[0, 2, 3]],
        *(square[k] + (1.0, 0.0, 0.0) for k in ([0, 1, 2], [0, 2, 3])),
    ]
    parts = np.array((0, 0, 1, 1))
    for names, length_m in ((("mapped_plating", "mapped_structure"), 6.0), (("plate", "frame"), 7.0)):
        both = Mesh(np.array(halves), names, parts)
        edges = edge_places(both.triangles_m, both.joined)
        assert STEP_M * len(edges) == pytest.approx(length_m, abs=2 * STEP_M)


def test_plates_above_the_limit_come_first_for_gauging_and_cracks_for_close_up():
    findings = [*FINDINGS, finding(3, "rust", (-1.5, 1.5, 0.5), 0.9, 0.4)]
    plates = plates_seen(ship(), side_walls(lambda points: points[:, 1] > 0), findings)
    shares = {each.plate.text: round(each.rust_share, 3) for each in plates if each.rust_m2}
    assert shares == {"Fr. 0 to 4, strake A, P": 0.2, "Fr. 4 to 8, strake B, P": 0.05}
    spots = gauging_spots(plates, RULES)
    assert [(each.plate.first, "15 %" in each.why) for each in spots] == [(0, True), (4, False)]
    assert [each.id for each, _ in close_up_spots(findings)] == [2, 3, 1]


def test_a_streak_along_an_edge_counts_with_its_length_and_rust_beside_the_edge_does_not(tmp_path):
    box = read_mesh(mesh(tmp_path / "box.stl"))
    edges = edge_places(box.triangles_m, box.part)
    x = np.arange(-1.0, 1.0, 0.04).tolist()
    streak = replace(finding(1, "rust", (0.0, 1.5, 0.0), 2.0, 0.1), places_m=tuple((v, 1.5, 0.0) for v in x))
    beside = replace(streak, places_m=tuple((v, 1.5, 0.3) for v in x))
    rusted_m = []
    for each in (streak, beside):
        port, _ = port_and_starboard([each], lambda points: points[:, 1] > 0, edges)
        rusted_m.append(port.edge_share * port.edges_m)
    assert rusted_m == pytest.approx((2.0, 0.0), abs=3 * STEP_M)
