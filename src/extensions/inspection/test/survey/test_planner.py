"""Plans in a small room: the share is that of an independent ray check, bounds hold, edits are checked."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
import trimesh

from flight_basics.errors import SurveyError
from inspection.survey import FlightParameters, SurveyCamera, SurveyParameters, optical_axes
from inspection.survey.checking import check_plan
from inspection.survey.closer import closer_plan
from inspection.survey.coverage import coverages_on
from inspection.survey.kernels.tours import (
    length_of,
    nearest_neighbour,
    one_tree_bound,
    perturb,
    shorten,
)
from inspection.survey.plan_file import read_plan, write_plan
from inspection.survey.planner import SurveyPlanner
from inspection.survey.surface.reading import read_surface
from inspection.survey.views.candidates import Candidates, lattice, lens_of

ASKED = SurveyParameters(spacing=1.0, patch=0.5, voxel=0.2, share=0.95, class_share=0.0)
SIZE_M = np.array((6.0, 4.0, 3.0))


@pytest.fixture(scope="module")
def room_file(tmp_path_factory):
    """A closed room with a pillar in it; its floor is at z = 0."""
    walls = trimesh.creation.box(SIZE_M)
    pillar = trimesh.creation.box((0.4, 0.4, 3.0))
    pillar.apply_translation((1.0, 0.0, 0.0))
    both = trimesh.util.concatenate([walls, pillar])
    both.apply_translation((0.0, 0.0, 1.5))
    path = tmp_path_factory.mktemp("room") / "room.stl"
    both.export(path)
    return path


@pytest.fixture(scope="module")
def planned(room_file):
    surface = read_surface(room_file, ASKED)
    planner = SurveyPlanner(
        surface.room, surface.patches, surface.ranges_m, asked=ASKED, source=str(room_file)
    )
    return surface, [each.plan for each in planner.improve(search_s=0.3)]


def shown(plan, surface, camera, asked):
    """Which patches a plan shows: a pixel's footprint by lines of sight beside its middle, one ray each."""
    patches, found = surface.patches, np.zeros(len(surface.patches), bool)
    for view in plan.views:
        axes = optical_axes(view.yaw_rad, view.tilt_rad)
        for m in np.flatnonzero(~found):
            point = (patches.points_m[m] - view.place_m) @ axes
            normal = patches.normals[m] @ axes
            distance = np.linalg.norm(point)
            if point[2] <= 0.0 or -(normal @ point) / distance < np.cos(np.radians(asked.incidence)):
                continue
            place = point[:2] / point[2]
            if (np.abs(place) > camera.half_extents).any():
                continue
            turns = np.linspace(0.0, np.pi, 60)
            ends = np.column_stack((place + 1e-5 * np.c_[np.cos(turns), np.sin(turns)], np.ones(60)))
            ends *= ((normal @ point) / (ends @ normal))[:, None]
            worst_mm = 1e3 * np.linalg.norm(ends - point, axis=1).max() / 1e-5 / camera.focal_px
            if worst_mm > asked.resolution * 1.001:
                continue
            way = (patches.points_m[m] - view.place_m) / distance
            if surface.ranges_m(np.array([view.place_m]), way[None])[0] >= distance - 0.02:
                found[m] = True
    return found


def test_places_near_a_surface_are_left_out_unless_they_show_what_no_other_place_does(room_file):
    surface = read_surface(room_file, ASKED)
    places_m = lattice(surface.room, 0.6)
    every = Candidates(surface.patches, places_m, SurveyCamera(), ASKED, surface.ranges_m)
    wall_m = np.min(np.hstack((places_m - (-3.0, -2.0, 0.0), (3.0, 2.0, 3.0) - places_m)), axis=1)
    pillar_m = np.linalg.norm(np.maximum(np.abs(places_m[:, :2] - (1.0, 0.0)) - 0.2, 0.0), axis=1)
    clearances_m = surface.room.clearances_m(places_m)
    np.testing.assert_allclose(clearances_m, np.minimum(wall_m, pillar_m), atol=2.0 * ASKED.voxel)
    preferred = clearances_m >= 0.9
    fewer, _ = every.preferring(preferred)
    assert preferred.sum() <= len(fewer.places_m) < len(places_m)
    alone = Candidates(surface.patches, places_m[preferred], SurveyCamera(), ASKED, surface.ranges_m)
    found = np.zeros(len(surface.patches), bool)
    for place, at_m in enumerate(fewer.places_m):
        k = int(np.flatnonzero((places_m == at_m).all(axis=1))[0])
        mine = fewer.seen[fewer.begins[place] : fewer.begins[place + 1]]
        np.testing.assert_array_equal(mine, every.seen[every.begins[k] : every.begins[k + 1]])
        assert preferred[k] or (every.reachable & ~alone.reachable)[mine].any()
        found[mine] = True
    assert found[every.reachable].all()


def test_a_small_uav_finds_places_between_what_a_coarse_lattice_passes_over(tmp_path):
    """Undersides of shelves that are 0.7 m apart."""
    shelves = [trimesh.creation.box((3.0, 2.0, 3.0))]
    for z_m in (-0.75, -0.05, 0.65):
        shelf = trimesh.creation.box((2.98, 0.5, 0.02))
        shelf.apply_translation((0.0, 0.74, z_m))
        shelves.append(shelf)
    trimesh.util.concatenate(shelves).export(tmp_path / "shelves.stl")
    shares = []
    for spacing in (0.7, 0.0):
        asked = SurveyParameters(radius=0.15, incidence=30.0, margin=0.0, voxel=0.05, spacing=spacing)
        assert asked.lattice_m == (spacing or 0.3)
        surface = read_surface(tmp_path / "shelves.stl", asked)
        places_m = lattice(surface.room, asked.lattice_m)
        found = Candidates(surface.patches, places_m, SurveyCamera(), asked, surface.ranges_m)
        is_under = (surface.patches.normals[:, 2] < -0.9) & (surface.patches.points_m[:, 2] < 1.4)
        shares.append(found.reachable[is_under].mean())
    assert shares[0] < 0.9 < shares[1]


def test_an_independent_check_shows_at_least_what_the_plan_tells(planned):
    surface, plans = planned
    plan = plans[-1]
    areas = surface.patches.areas_m2
    share = areas[shown(plan, surface, SurveyCamera(), ASKED)].sum() / plan.figures["reachable_m2"]
    assert share >= plan.figures["share"] - 1e-6
    assert plan.figures["share"] >= ASKED.share


def test_a_plan_with_a_reserve_shows_more_finely_than_asked_and_is_judged_by_what_is_asked(room_file):
    asked = replace(ASKED, resolution=2.0, finer=0.2)
    surface, camera = read_surface(room_file, asked), SurveyCamera()
    planner = SurveyPlanner(surface.room, surface.patches, surface.ranges_m, asked=asked)
    *_, plan = (each.plan for each in planner.improve(search_s=0.3, bound=False))
    found = shown(plan, surface, camera, replace(asked, resolution=1.6))
    areas_m2 = surface.patches.areas_m2
    assert areas_m2[found].sum() >= plan.figures["share"] * plan.figures["reachable_m2"] - 1e-6
    (with_it,) = coverages_on(surface, ((),), camera, asked)
    (without,) = coverages_on(surface, ((),), camera, replace(asked, finer=0.0))
    assert (with_it.reachable == without.reachable).all()


def test_the_surface_is_the_inside_of_the_walls_and_the_outside_of_the_pillar(planned):
    surface, _ = planned
    x, y, z = SIZE_M
    expected = 2 * (x * y + x * z + y * z) - 2 * 0.4**2 + 4 * 0.4 * z
    assert surface.patches.areas_m2.sum() == pytest.approx(expected, rel=0.03)


def test_later_plans_are_no_worse_and_bounds_are_never_above_the_plan(planned):
    _, plans = planned
    numbers = [len(plan.views) for plan in plans]
    assert numbers[-1] <= numbers[1]
    figures = plans[-1].figures
    assert 0.0 < figures["photographs_lp_bound"] <= numbers[-1] + 1e-6
    assert 0.0 < figures["tour_bound_s"] <= figures["tour_s"] <= figures["tour_nearest_s"] + 1e-6


def test_tours_are_no_longer_than_the_nearest_neighbour_s_and_no_shorter_than_the_bound():
    rng = np.random.default_rng(3)
    for count in (4, 7, 8, 12, 40):
        places = rng.random((count, 3))
        costs = np.linalg.norm(places[:, None] - places[None], axis=2)
        first = nearest_neighbour(costs, 0)
        tour = first.copy()
        shorten(costs, tour)
        tour = perturb(costs, tour, rng.random((20, 3)), 50)
        assert sorted(tour) == list(range(count))
        length = length_of(costs, tour)
        assert one_tree_bound(costs, length, 200) <= length + 1e-9 <= length_of(costs, first) + 2e-9


def test_a_plan_is_read_back_as_it_was_written_and_can_be_flown(planned, tmp_path):
    surface, plans = planned
    write_plan(tmp_path / "plan.yaml", plans[-1])
    back = read_plan(tmp_path / "plan.yaml")
    assert back.asked == ASKED
    assert back.flying == FlightParameters()
    for a, b in zip(back.views, plans[-1].views):
        np.testing.assert_allclose(a.place_m, b.place_m, atol=1e-3)
        assert a.yaw_rad == pytest.approx(b.yaw_rad, abs=1e-3)
    check_plan(back, surface.room)


def test_a_plan_that_was_edited_wrongly_is_refused_with_a_sentence(planned, tmp_path):
    surface, plans = planned
    edited = "id: 1, tilt: 0, yaw: 0, at: [2.95, 0, 1.5]}\n  - {id: 2, at: ["
    path = tmp_path / "plan.yaml"
    write_plan(path, plans[-1])
    path.write_text(path.read_text().replace("id: 1, at: [", edited, 1))
    with pytest.raises(SurveyError, match="from a surface"):
        check_plan(read_plan(path), surface.room)


def test_files_that_are_no_surface_are_refused_with_a_sentence(tmp_path):
    (tmp_path / "no.stl").write_bytes(b"nothing")
    with pytest.raises(SurveyError):
        read_surface(tmp_path / "no.stl", ASKED)
    with pytest.raises(SurveyError, match="no such file"):
        read_surface(tmp_path / "missing.stl", ASKED)
    with open(tmp_path / "huge.stl", "wb") as stream:
        stream.truncate(84 + 50 * 5_000_000)
    with pytest.raises(SurveyError, match="5,000,000 triangles"):
        read_surface(tmp_path / "huge.stl", ASKED)


def test_a_room_with_a_hole_in_its_wall_is_surveyed_from_inside(tmp_path):
    room = trimesh.creation.box(SIZE_M).subdivide().subdivide().subdivide()
    hole = int(np.argmax(room.triangles_center @ (1.0, 0.1, 0.1)))
    lost_m2 = room.area_faces[hole]
    room.update_faces(np.arange(len(room.faces)) != hole)
    room.export(tmp_path / "open.stl")
    surface = read_surface(tmp_path / "open.stl", ASKED, (0.0, 0.0, 0.0))
    planner = SurveyPlanner(surface.room, surface.patches, surface.ranges_m, asked=ASKED)
    *_, last = planner.improve(search_s=0.0, bound=False)
    plan = last.plan
    x, y, z = SIZE_M
    inside_m2 = 2.0 * (x * y + x * z + y * z) - lost_m2
    assert plan.figures["reachable_m2"] == pytest.approx(inside_m2, rel=0.05)
    assert plan.figures["share"] >= ASKED.share


def test_passing_too_fast_for_the_exposure_is_refused_with_a_sentence():
    with pytest.raises(SurveyError, match="blurs by 1 mm"):
        lens_of(SurveyCamera(exposure=0.002), SurveyParameters(resolution=1.0), speed_m_s=0.5)


def test_the_endurance_is_that_of_the_iris_in_the_paper():
    """Liu et al. (2017): 1.5 kg hover on 176 W; 80 % of 56.6 Wh last 15.4 minutes."""
    flying = FlightParameters(mass=1.5, battery=56.6, electronics=0.0)
    assert 0.8 * flying.endurance_s / 60.0 == pytest.approx(15.4, abs=0.1)
    assert FlightParameters(endurance=100.0).endurance_s == 100.0


class Spot(NamedTuple):
    position_m: tuple[float, float, float]
    normal: tuple[float, float, float]


def test_a_closer_look_shows_each_place_in_its_middle_as_fine_as_asked(planned, room_file):
    surface, plans = planned
    spots = [
        Spot((2.0, 2.0, 1.5), (0.0, -1.0, 0.0)),  # on a wall
        Spot((-3.0, -1.7, 1.5), (1.0, 0.0, 0.0)),  # in a corner, where the UAV has no room in front
        Spot((1.0, 0.0, 1.5), (1.0, 0.0, 0.0)),  # in the pillar
    ]
    closer = closer_plan(plans[-1], spots, surface.room, surface.ranges_m, 0.3, np.random.default_rng(1))
    assert closer.hidden == (2,)
    check_plan(closer.plan, surface.room)
    assert len(closer.plan.views) == 2
    focal_px = closer.plan.camera.focal_px
    for spot in spots[:2]:

        def off_m(view, spot=spot):
            axes = optical_axes(view.yaw_rad, view.tilt_rad)
            return np.linalg.norm(((np.array(spot.position_m) - view.place_m) @ axes)[:2])

        view = min(closer.plan.views, key=off_m)
        assert off_m(view) < 0.02
        sight = np.array(spot.position_m) - view.place_m
        far_m = np.linalg.norm(sight)
        cosine = -(sight @ spot.normal) / far_m
        assert 1e3 * far_m / focal_px / cosine == pytest.approx(0.3, abs=0.01)
        assert cosine > np.cos(np.radians(46.0))
    assert closer.plan.views[0] != closer.plan.views[1]


def test_a_closer_look_at_what_nobody_sees_is_refused(planned):
    surface, plans = planned
    inside = Spot((1.0, 0.0, 1.5), (1.0, 0.0, 0.0))
    with pytest.raises(SurveyError, match="None of 1 places"):
        closer_plan(plans[-1], [inside], surface.room, surface.ranges_m, 0.3, np.random.default_rng(1))
