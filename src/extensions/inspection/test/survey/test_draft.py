"""A draft has the best photographs near home, at once; the plan that completes it begins with them."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from inspection.camera.photograph_pose import PhotographPose
from inspection.survey import SurveyParameters
from inspection.survey.checking import check_plan
from inspection.survey.coverage import coverages_on
from inspection.survey.plan import Draft
from inspection.survey.plan_file import read_plan, write_plan
from inspection.survey.planner import SurveyPlanner, completed
from inspection.survey.surface.reading import read_surface
from inspection.survey.views.candidates import near_home

ASKED = SurveyParameters(spacing=1.0, patch=0.5, voxel=0.2, share=0.95, class_share=0.0, resolution=0.5)
HOME_M = (-2.0, -1.0, 1.5)
SEARCH_S = 0.3
SETTLED = 7
"""Photographs of the draft: one for each 30 of 208 m2."""


@pytest.fixture(scope="module")
def rooms(tmp_path_factory):
    """Two rooms of 6 x 4 x 3 m beside each other; a door leads through the wall at x = 0, far from home."""
    outside = trimesh.creation.box(bounds=((-6.0, -2.0, 0.0), (6.0, 2.0, 3.0)))
    wall = [
        trimesh.creation.box(bounds=((-0.1, -2.0, 0.0), (0.1, 0.4, 3.0))),
        trimesh.creation.box(bounds=((-0.1, 0.4, 2.4), (0.1, 2.0, 3.0))),
    ]
    path = tmp_path_factory.mktemp("rooms") / "rooms.stl"
    trimesh.util.concatenate([outside, *wall]).export(path)
    return path


@pytest.fixture(scope="module")
def drafted(rooms):
    surface = read_surface(rooms, ASKED, HOME_M)
    planner = SurveyPlanner(surface.room, surface.patches, surface.ranges_m, asked=ASKED, source=str(rooms))
    draft = planner.first_flight(seed=3, search_s=SEARCH_S)
    assert draft is not None
    return surface, planner, draft


def test_a_draft_has_few_photographs_that_can_be_flown_and_tells_how_to_go_on(drafted, tmp_path):
    surface, _, draft = drafted
    assert len(draft.views) == SETTLED == int(np.ceil(surface.patches.areas_m2.sum() / 30.0))
    assert draft.draft == Draft(3, SEARCH_S)
    check_plan(draft, surface.room)
    write_plan(tmp_path / "plan.yaml", draft)
    assert read_plan(tmp_path / "plan.yaml").draft == draft.draft


def test_the_whole_plan_begins_with_the_draft_and_shows_as_much_as_one_without_it(drafted):
    surface, planner, draft = drafted
    whole = completed(draft, surface)
    assert whole.draft is None
    assert whole.views[:SETTLED] == draft.views
    assert whole.figures["photographs"] == len(whole.views) > SETTLED
    check_plan(whole, surface.room)
    *_, other = (each.plan for each in planner.improve(seed=3, search_s=SEARCH_S, bound=False))
    assert len(whole.flights) == len(other.flights) == 1  # the draft is no flight of its own
    assert len(whole.views) < 1.15 * len(other.views)
    assert (
        whole.figures["share"] > other.figures["share"] - 0.01
    )  # the lattice is too coarse for what is asked
    # An independent judge: Embree's rays through the pixels of each photograph
    taken = [[PhotographPose.of_view(view) for view in plan.views] for plan in (draft, whole, other)]
    by_draft, by_whole, by_other = coverages_on(surface, taken, whole.camera, ASKED)
    assert by_draft.share() < 0.5 * by_whole.share()
    assert by_whole.share() > by_other.share() - 0.02
    assert completed(other, surface) is other


def test_a_draft_that_is_edited_into_a_wall_is_completed_all_the_same(drafted):
    surface, _, draft = drafted
    (flight,) = draft.flights
    walled = replace(flight.views[2], view=replace(flight.views[2].view, place_m=(0.0, -1.0, 1.0)))
    edited = replace(draft, flights=(replace(flight, views=(*flight.views[:2], walled, *flight.views[3:])),))
    whole = completed(edited, surface)
    assert whole.views[:SETTLED] == edited.views
    assert len(whole.views) > SETTLED
    assert len(whole.flights) > 1


def test_what_the_first_flight_shows_wholly_needs_no_other(rooms):
    asked = replace(ASKED, resolution=3.0)
    surface = read_surface(rooms, asked, HOME_M)
    planner = SurveyPlanner(surface.room, surface.patches, surface.ranges_m, asked=asked, source=str(rooms))
    *_, plan = (each.plan for each in planner.improve(search_s=SEARCH_S, bound=False))
    again = completed(replace(plan, draft=Draft(1, SEARCH_S)), surface)
    assert again.views == plan.views
    assert again.figures["share"] >= asked.share


def test_the_nearest_places_are_on_this_side_of_a_wall(drafted):
    surface, _, _ = drafted
    room = surface.room
    z, y, x = np.nonzero(room.flyable[::2, ::2, ::2])
    places_m = room.outer(2 * np.column_stack((z, y, x)) + 0.5)
    home_m = np.array((-0.9, -1.3, 1.5))
    away_m = np.linalg.norm(places_m - home_m, axis=1)
    inside = away_m < 1.9  # the door is farther
    near = near_home(replace(room, home_m=home_m), places_m, int(inside.sum()))
    beyond = inside & (places_m[:, 0] > 0.0)
    assert beyond.any()
    assert len(near) == inside.sum() - beyond.sum()
    assert (near[:, 0] < 0.0).all()
