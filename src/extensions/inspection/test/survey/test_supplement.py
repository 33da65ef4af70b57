"""More photographs show what a plan's did not, and cost counts where the UAV has little room."""

import math

import numpy as np
import pytest
import trimesh

from flight_basics.errors import SurveyError
from inspection.camera.photograph_pose import PhotographPose
from inspection.survey import FlightParameters, SurveyCamera, SurveyParameters
from inspection.survey.coverage import coverages_on
from inspection.survey.plan import Flight, PlannedView, SurveyPlan
from inspection.survey.planner import SurveyPlanner
from inspection.survey.supplement import Supplement
from inspection.survey.surface.reading import read_surface
from inspection.survey.views.candidates import COST_MOST, Candidates, lattice
from inspection.survey.views.cover import Cover

ASKED = SurveyParameters(spacing=1.0, patch=0.5, voxel=0.2, share=0.95, class_share=0.0)


@pytest.fixture(scope="module")
def surface(tmp_path_factory):
    """A closed room of 8 x 6 x 4 m."""
    room = trimesh.creation.box((8.0, 6.0, 4.0))
    room.apply_translation((0.0, 0.0, 2.0))
    path = tmp_path_factory.mktemp("room") / "room.stl"
    room.export(path)
    return read_surface(path, ASKED)


def planned(surface):
    planner = SurveyPlanner(surface.room, surface.patches, surface.ranges_m, asked=ASKED)
    *_, last = planner.improve(search_s=0.3, bound=False)
    return last.plan


def test_with_more_photographs_the_share_is_reached_that_was_missed(surface):
    plan = planned(surface)
    supplement = Supplement(plan, surface)
    taken = [PhotographPose.of_view(view) for view in plan.views[::2]]
    for each in taken:
        supplement.add(each)
    more = supplement.plan_more((), np.random.default_rng(1))
    assert more is not None
    before, after = coverages_on(
        surface, (taken, [*taken, *map(PhotographPose.of_view, more.views)]), plan.camera, ASKED
    )
    assert before.share() < 0.8
    assert after.share() >= ASKED.share
    assert len(more.views) <= len(plan.views)
    for view in more.views:
        supplement.add(PhotographPose.of_view(view))
    assert supplement.plan_more((), np.random.default_rng(1)) is None


def test_no_photograph_is_planned_where_none_could_be_taken(surface):
    view = PlannedView(planned(surface).views[0])
    flights = (Flight((view,), 9.0, 1.0),)
    plan = SurveyPlan("", tuple(surface.room.home_m), SurveyCamera(), ASKED, FlightParameters(), flights)
    supplement = Supplement(plan, surface)
    left_out_m = [each.place_m for each in planned(surface).views]
    more = supplement.plan_more(left_out_m, np.random.default_rng(1))
    for each in more.views:
        assert np.linalg.norm(np.array(left_out_m) - each.place_m, axis=1).min() > 0.5


@pytest.mark.table("place_m", [(math.nan, 1.0, 2.0), (1.0, 2.0), (math.inf, 0.0, 0.0)])
def test_a_place_that_is_none_is_named_and_leaves_no_place_out(surface, place_m):
    supplement = Supplement(planned(surface), surface)
    with pytest.raises(SurveyError, match="not three finite numbers"):
        supplement.plan_more([place_m], np.random.default_rng(1))


def test_a_place_costs_more_the_less_room_it_has_and_the_plan_avoids_it(surface):
    places_m = lattice(surface.room, 0.6)
    roomy = SurveyParameters(**{**ASKED.__dict__, "comfort": 1.0})
    every = Candidates(surface.patches, places_m, SurveyCamera(), roomy, surface.ranges_m)
    kept = every.comfortable(surface.room)
    clearances_m = surface.room.clearances_m(kept.places_m)
    lack_m = roomy.radius + roomy.comfort - clearances_m
    np.testing.assert_allclose(kept.costs[lack_m <= 0.0], 1.0)
    assert ((kept.costs > 1.0) == (lack_m > 1e-9)).all()
    assert kept.costs.max() <= COST_MOST
    order = np.argsort(lack_m)
    assert (np.diff(kept.costs[order]) >= -1e-9).all()

    def lacking(candidates):
        cover = Cover(candidates, roomy)
        cover.fill()
        places_m = np.array([view.place_m for view in cover.views])
        return (surface.room.clearances_m(places_m) < roomy.radius + roomy.comfort).mean()

    assert lacking(kept) < 0.5 * lacking(every)
