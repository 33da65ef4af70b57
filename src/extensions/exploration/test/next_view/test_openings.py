"""An opening that a UAV sees through, but does not fit through, is named with what would pass."""

import functools
import re

import numpy as np
import pytest
from voxel_room import Flight, beams, next_places, room

from exploration.next_view import (
    End,
    Exploration,
    ExplorationParameters,
    Explorer,
    ExplorerParameters,
)
from exploration.next_view.unknown.leftovers import Why, behind_openings
from exploration.next_view.unknown.openings import narrow_openings, radii_of
from exploration.planning import PlannerParameters
from flight_basics.errors import NoPathError, ParameterError

UAV = PlannerParameters(radius=0.35, margin=0.15)
"""0.5 m, and on voxels of 0.2 m so far that the squared distance is a whole number: sqrt(7) * 0.2 m."""
NEEDED_M = 2.0 * 0.2 * np.sqrt(7.0)
SMALLER = {"small_quad": 0.2, "huge_quad": 0.6}

PARTS = ((1.2, 2.8, 0.0, 3.0), (3.6, 9.0, 0.0, 3.0), (2.8, 3.6, 0.0, 0.8), (2.8, 3.6, 1.8, 3.0))
"""Of the bulkhead beside an opening at y from 2.8 to 3.6 m: from and to in y, and in z."""


def bulkhead(y_m, z_m, x_m=4.0):
    """A wall across a room with an opening, from and to in y and z."""
    whole, far = 10.0, ((x_m, 0.0, 0.0), (x_m + 0.2, y_m[0], 10.0))
    return (
        far,
        ((x_m, y_m[1], 0.0), (x_m + 0.2, whole, 10.0)),
        ((x_m, y_m[0], 0.0), (x_m + 0.2, y_m[1], z_m[0])),
        ((x_m, y_m[0], z_m[1]), (x_m + 0.2, y_m[1], whole)),
    )


@functools.cache
def explored(walls, parameters=UAV, length_m=8.2):
    """A flight through a room of 4.2 x 3 m, its explorer, and what lies behind narrow openings."""
    directions = beams(elevation_rad=1.2, rings=40)
    flight = Flight(room((length_m, 4.2, 3.0), walls), (2.1, 2.1, 1.5), directions, parameters=parameters)
    lidar = {"elevation_min": -1.2, "elevation_max": 1.2}
    explorer = Explorer(ExplorerParameters(spacing=0.4, reach=8.0, **lidar))
    decision, _ = flight.explore(explorer)
    assert not decision.is_shut_in
    space = flight.space()
    nodes = explorer.places(space, flight.place_m)
    return flight, explorer, narrow_openings(space, nodes, parameters, SMALLER)


def test_a_manhole_of_0_8_m_is_named_with_its_place_and_width_and_what_would_pass():
    flight, explorer, behind = explored(bulkhead((1.6, 2.4), (0.8, 1.8)))
    (opening,) = behind.openings
    assert opening.place_m == pytest.approx((4.1, 2.0, 1.3), abs=0.3)
    assert opening.width_m == pytest.approx(0.8 + 0.2)  # its edges may lie a tenth of a metre in the walls
    assert opening.needed_m == pytest.approx(NEEDED_M)
    assert "model:=small_quad" in str(opening)
    assert "huge_quad" not in str(opening)
    assert "at (4." in str(opening)
    assert "about 1.0 m wide (map of 0.2 m), this UAV needs 1.1 m" in str(opening)
    space = flight.space()
    left = explorer.left_over(space, space, space, flight.place_m)
    named = behind_openings(left, behind, space)
    is_behind = {each.place_m[0] > 3.9 for each in named if each.why is Why.NARROW}
    assert is_behind == {True}
    unnamed_m2 = sum(each.area_m2 for each in named if each.place_m[0] > 4.4 and each.why is not Why.NARROW)
    assert unnamed_m2 < 0.3
    assert all("1.0 m wide" in each.words for each in named if each.why is Why.NARROW)


def test_an_opening_of_two_voxels_is_named_too():
    """As noise leaves it of one of 0.6 m: no voxel in it has more than one to its side."""
    _, _, behind = explored(bulkhead((2.0, 2.4), (0.8, 1.8)))
    (opening,) = behind.openings
    assert opening.width_m == pytest.approx(0.4 + 0.2)
    assert opening.place_m == pytest.approx((4.1, 2.2, 1.3), abs=0.5)


@pytest.mark.table("walls", [1, 2, 3])
def test_a_plan_through_a_door_that_is_too_narrow_names_the_door_not_what_is_seen_behind_it(walls):
    """What is seen through a door alone is known as narrowly as the door. It stands at x = 4 m."""
    thick = tuple(wall for n in range(walls) for wall in bulkhead((1.6, 2.4), (0.2, 2.2), 4.0 + 0.2 * n))
    flight, _, behind = explored(thick)
    with pytest.raises(NoPathError) as told:
        flight.planner.plan(flight.place_m, np.array((6.5, 2.0, 1.3)))
    x_m, y_m, z_m = map(float, re.search(r"too narrow at \((.*?), (.*?), (.*?)\)", str(told.value)).groups())
    assert 4.0 < x_m < 4.0 + 0.2 * walls
    assert 1.6 < y_m < 2.4
    assert 0.2 < z_m < 2.2
    assert "may need 0.40 m to each side there, but" in str(told.value)
    assert 4.0 < behind.openings[0].place_m[0] < 4.0 + 0.2 * walls


def test_an_exploration_tells_the_opening_with_its_end():
    flight, explorer, _ = explored(bulkhead((1.6, 2.4), (0.8, 1.8)))
    asked = ExplorationParameters(first_sink=0.0)
    exploration = Exploration(flight.planner, explorer, asked, smaller=SMALLER)
    exploration.begin(0.0, flight.place_m)
    for here_m in next_places(exploration, flight, 0.5):
        flight.place_m = here_m
    exploration.look(900.0, flight.place_m)
    assert exploration.explored.end is End.EXPLORED
    assert "1.0 m wide" in exploration.explored.reason
    assert "model:=small_quad" in exploration.explored.reason
    assert exploration.explored.left_m2(Why.NARROW) > 5.0


def test_two_openings_are_named_each():
    """A bulkhead has one at y = 0.6 to 1.2 m and one at 2.8 to 3.6 m. A wall divides what lies behind it."""
    first = [wall for wall in bulkhead((0.6, 1.2), (1.0, 1.8)) if wall[0][1] != 1.2]
    second = [((4.0, y0, z0), (4.2, y1, z1)) for y0, y1, z0, z1 in PARTS]
    _, _, behind = explored((*first, *second, ((4.2, 2.0, 0.0), (8.2, 2.2, 3.0))))
    assert sorted(opening.place_m[1] for opening in behind.openings) == pytest.approx([0.9, 3.2], abs=0.31)
    assert sorted(opening.width_m for opening in behind.openings) == pytest.approx([0.6 + 0.2, 0.8 + 0.2])


def test_an_opening_that_it_passes_and_a_room_without_one_name_nothing():
    flight, _, behind = explored(bulkhead((1.2, 3.0), (0.2, 2.8)))
    assert behind.openings == ()
    assert (flight.kinds[~flight.filled] != 0).mean() > 0.97
    _, _, behind = explored((), length_m=5.0)
    assert behind.openings == ()


@pytest.mark.table("depth_m", [0.8, 1.2])
@pytest.mark.table(("y_m", "z_m"), [((1.8, 2.4), (0.8, 1.8)), ((1.8, 2.4), (0.2, 2.8))])
def test_a_niche_whose_back_is_known_is_no_opening(depth_m, y_m, z_m):
    solid = bulkhead(y_m, z_m)
    thick = [(low, (8.2, *high[1:])) for low, high in solid]
    back = ((4.0 + depth_m, y_m[0], z_m[0]), (8.2, y_m[1], z_m[1]))
    _, _, behind = explored((*thick, back))
    assert behind.openings == ()


def test_the_margin_that_would_pass_is_named():
    """0.8 m leave 0.4 m to each side: 0.05 m beside a radius of 0.35 m. A radius of 0.45 m has no margin."""
    _, _, behind = explored(bulkhead((1.6, 2.4), (0.8, 1.8)))
    assert "margin:=0.05 instead of 0.15" in str(behind.openings[0])
    _, _, behind = explored(bulkhead((1.6, 2.4), (0.8, 1.8)), PlannerParameters(radius=0.45, margin=0.05))
    assert "margin" not in str(behind.openings[0])


@pytest.mark.table("given", ["small_quad", ["small_quad"], {"small_quad": "small"}, {"small_quad": -0.2}])
def test_radii_that_are_none_are_refused_in_a_sentence(given):
    with pytest.raises(ParameterError, match="smaller_uavs"):
        radii_of(given)
