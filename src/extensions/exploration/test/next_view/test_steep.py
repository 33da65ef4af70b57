"""Straight up and down, where only range finders see."""

import math

import numpy as np
import pytest
from voxel_room import SIDE_M, Flight, beams, next_places, open_box, room

from exploration.next_view import (
    End,
    Exploration,
    ExplorationParameters,
    Explorer,
    ExplorerParameters,
)
from exploration.next_view.steep import SteepSteps
from exploration.planning import FREE, UNKNOWN, PathPlanner, PlannerParameters

HOVER_M = np.array((1.0, 2.0, 3.0))


@pytest.mark.parametrize(
    ("steep", "cepa_looks_up"),
    [
        (True, True),
        pytest.param(False, True, marks=pytest.mark.long),
        pytest.param(True, False, marks=pytest.mark.long),
    ],
)
def test_a_hole_in_the_deck_above_is_climbed_through_only_if_steep_steps_are_allowed(steep, cepa_looks_up):
    # Given a level lidar, whose beams do not lead through a hole above, and a room on the deck
    slab = [
        ((0.2, 0.2, 2.2), (2.6, 3.2, 2.4)),
        ((4.2, 0.2, 2.2), (4.8, 3.2, 2.4)),
        ((2.6, 0.2, 2.2), (4.2, 0.8, 2.4)),
        ((2.6, 2.4, 2.2), (4.2, 3.2, 2.4)),
    ]
    straight = np.array([(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)])  # what range finders see
    directions = np.concatenate((beams(around=60), straight))
    flight = Flight(room((5.0, 3.4, 4.4), slab), (1.3, 1.3, 1.2), directions)
    explorer = Explorer(ExplorerParameters(spacing=0.4, reach=8.0))
    asked = ExplorationParameters(first_sink=0.0, steep=steep)
    exploration = Exploration(flight.planner, explorer, asked)
    exploration.begin(0.0, flight.place_m)
    occupied_m = SIDE_M * (np.argwhere(flight.filled)[:, ::-1] + 0.5)
    nearest_m = math.inf
    for there_m in next_places(exploration, flight, 0.3):
        climb_m = there_m[2] - flight.place_m[2]
        ahead = (there_m + np.array((0.0, 0.0, math.copysign(0.4, climb_m)))) / SIDE_M
        if cepa_looks_up and flight.filled[tuple(ahead.astype(int)[::-1])]:
            continue  # a range finder sees that, and CEPA does not fly there
        flight.place_m = there_m
        flight.look()
        nearest_m = min(nearest_m, float(np.linalg.norm(occupied_m - flight.place_m, axis=1).min()))
    assert exploration.explored.end is End.EXPLORED
    above = flight.kinds[12:21, 1:16, 1:24]
    known = np.count_nonzero(above != UNKNOWN) / above.size
    assert (known > 0.95) if steep else (known < 0.5)
    # And it kept away from what is there, though no beam had told of it
    assert nearest_m > 0.3


def explored(filled, directions, view_choice, is_steep=True):
    """Explore with range finders or without; return the flight and the exploration."""
    flight = Flight(filled, (1.3, 1.7, 1.2), directions)
    explorer = Explorer(ExplorerParameters(spacing=0.4, reach=8.0, view_choice=view_choice), is_steep)
    exploration = Exploration(flight.planner, explorer, ExplorationParameters(first_sink=0.0, steep=is_steep))
    exploration.begin(0.0, flight.place_m)
    for there_m in next_places(exploration, flight, 0.3):
        flight.way_m += math.dist(there_m, flight.place_m)
        flight.place_m = there_m
        flight.look()
    return flight, exploration


@pytest.mark.parametrize("has_range_finders", [True, pytest.param(False, marks=pytest.mark.long)])
def test_a_high_narrow_room_is_climbed_straight_where_a_range_finder_looks(has_range_finders):
    # Given beams that rise by 0.8 m over the whole length of a room that is 5.2 m high
    straight = np.array([(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)])
    directions = np.concatenate((beams(around=60), straight)) if has_range_finders else beams(around=60)
    flight, exploration = explored(room((4.4, 3.6, 5.6)), directions, "volume")
    assert exploration.explored.end is End.EXPLORED
    known = (flight.kinds[~flight.filled] != UNKNOWN).mean()
    # Then some climbs suffice; crossings of the room take 60 m. Without range finders it ends, too
    if has_range_finders:
        assert known > 0.99
        assert flight.way_m < 50.0


@pytest.mark.parametrize(("is_steep", "known"), [(True, (0.97, 1.0))])
def test_what_is_under_a_ceiling_where_no_level_view_leads_is_seen_from_close_below_it(is_steep, known):
    straight = np.array([(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)])
    directions = np.concatenate((beams(around=180), straight))
    flight, exploration = explored(room((3.6, 3.6, 3.8)), directions, "border", is_steep)
    assert exploration.explored.end is End.EXPLORED
    ceiling, below = flight.kinds[18, 1:17, 1:17], flight.kinds[17, 1:17, 1:17]
    assert known[0] <= ((ceiling != UNKNOWN) | (below != UNKNOWN)).mean() <= known[1]


@pytest.mark.table(("free_step", "goes_on", "tried"), [(0, True, 1), (9, True, 3), (None, False, 0)])
def test_steep_steps_without_a_way_are_tried_at_the_same_look(free_step, goes_on, tried):
    # Given steps up from five places, of which one at most has a way
    x = np.arange(5) if free_step is not None else np.zeros(0)
    steps_m = np.stack([np.stack((1.0 + x, 2.0 + 0 * x, z + 0 * x), -1) for z in (3.0, 3.2, 3.4)], 1)
    steep = SteepSteps(open_box(), lambda space, here_m: steps_m, 0.4)
    asked = []

    def set_out(end_m):
        asked.append(round(end_m[0] - 1.0))
        return asked[-1] == free_step

    assert steep.set_out(0.0, HOVER_M, set_out) is goes_on
    assert len(asked) == tried


def test_a_steep_step_is_flown_only_as_far_as_a_range_finder_has_seen():
    """The planar CEPA of small UAVs does not look up: a step that nobody has seen ends in the deck."""
    # Given a step of 0.4 m from z = 4.3 m on, above which nothing is known
    kinds = np.full((32, 32, 32), FREE, np.uint8)
    kinds[22:] = UNKNOWN
    step_m = np.stack((np.full(3, 1.1), np.full(3, 2.1), (4.3, 4.5, 4.7)), -1)[None]
    planner = PathPlanner(PlannerParameters(radius=0.3, margin=0.1))
    planner.update_map(0.2, 32, np.zeros((1, 3), np.int64), kinds.reshape(1, -1))
    steep = SteepSteps(planner, lambda space, here_m: step_m, 0.4)
    # Then the UAV flies below it, from where a range finder looks up
    np.testing.assert_allclose(steep.begin(0.0, HOVER_M), step_m[0, 0])
    steep.settle()
    # When it is there and nothing came of it, then there is no step
    assert steep.begin(1.0, step_m[0, 0]) is None
    # When the range finder has seen 0.2 m more, then it climbs so far
    kinds[22, 10, 5] = FREE
    planner.update_map(0.2, 32, np.zeros((1, 3), np.int64), kinds.reshape(1, -1))
    np.testing.assert_allclose(steep.begin(2.0, step_m[0, 0]), step_m[0, 1])
