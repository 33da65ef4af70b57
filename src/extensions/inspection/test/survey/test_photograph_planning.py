"""How photographs are planned is named by a parameter, and may be a class of one's own."""

from dataclasses import replace

import pytest
import trimesh

from flight_basics.errors import ParameterError
from inspection.survey import SurveyParameters
from inspection.survey.planner import SurveyPlanner
from inspection.survey.surface.reading import read_surface
from inspection.survey.views.planning import PHOTOGRAPH_PLANNINGS, GreedyPlanning

ASKED = SurveyParameters(spacing=1.0, patch=0.5, voxel=0.2, share=0.9, class_share=0.0)


class Patient(GreedyPlanning):
    """Keeps what is idle, and does not search."""

    def fill(self, cover, most=None):
        cover.fill(most=most)

    def improve(self, cover, rng, goes_on):
        assert cover.is_enough()


@pytest.fixture
def box(tmp_path):
    walls = trimesh.creation.box((4.0, 3.0, 3.0))
    walls.apply_translation((0.0, 0.0, 1.5))
    walls.export(tmp_path / "box.stl")
    return tmp_path / "box.stl"


def planner(box, name):
    surface, asked = read_surface(box, ASKED), replace(ASKED, planning=name)
    return SurveyPlanner(surface.room, surface.patches, surface.ranges_m, asked=asked, source=str(box))


def test_a_way_of_one_s_own_is_one_class_and_one_entry(box, monkeypatch):
    monkeypatch.setitem(PHOTOGRAPH_PLANNINGS, "patient", Patient)
    own, greedy = (
        [*planner(box, name).improve(search_s=0.3, bound=False)][-1].plan for name in ("patient", "greedy")
    )
    assert own.figures["share"] >= 0.9
    assert greedy.figures["share"] >= 0.9
    assert len(own.views) >= len(greedy.views)


def test_a_way_that_there_is_not_is_refused_with_those_that_there_are(box, monkeypatch):
    monkeypatch.setitem(PHOTOGRAPH_PLANNINGS, "patient", Patient)
    for other in PHOTOGRAPH_PLANNINGS.keys() - {"greedy", "patient"}:
        monkeypatch.delitem(PHOTOGRAPH_PLANNINGS, other)
    with pytest.raises(ParameterError, match=r"planning is 'annealing'; it must be one of greedy, patient\."):
        planner(box, "annealing")
