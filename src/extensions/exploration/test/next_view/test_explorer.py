"""An exploration ends, and only when nothing that the UAV can reach is left to see."""

import dataclasses
import math

import numpy as np
import pytest
from drawn_voxels import voxels_on
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from voxel_room import PLANNER, SIDE_M, TILE, Flight, beams, reachable, room

from exploration.next_view import Explorer, ExplorerParameters
from exploration.next_view.unknown.leftovers import Why
from exploration.planning import FREE, UNKNOWN

LIDAR = {"spacing": 0.4, "reach": 8.0}


def explored(filled, start_m, **lidar):
    flight = Flight(filled, start_m, **lidar)
    decision, _ = flight.explore(Explorer(ExplorerParameters(**LIDAR)))
    return flight, decision


def left_over(explorer, flight):
    """What stays unknown from where a flight has ended."""
    space, anywhere = (flight.planner.space(0.0, flight.place_m, with_far=far) for far in (True, False))
    return explorer.left_over(space, space, anywhere, flight.place_m)


def test_two_rooms_with_a_door_of_1_2_m_are_known_at_the_end():
    wall = [((3.0, 0.0, 0.0), (3.2, 2.0, 2.4)), ((3.0, 3.2, 0.0), (3.2, 4.6, 2.4))]
    flight, decision = explored(room((6.2, 4.6, 2.4), wall), (1.3, 1.3, 1.2))
    assert decision.goal_m is None
    assert not decision.is_shut_in
    known = flight.kinds != UNKNOWN
    assert known[~flight.filled].mean() > 0.99


@settings(max_examples=settings.default.max_examples // 10)
@given(st.integers(0, 2**32 - 1))
def test_nothing_reachable_is_unknown_when_it_says_so(seed):
    """In rooms with boxes: all places where the UAV fits are known to be free."""
    rng = np.random.default_rng(seed)
    boxes = [
        ((x, y, 0.0), (x + w, y + d, h))
        for x, y, w, d, h in rng.uniform((2.4, 0.4, 0.4, 0.4, 0.4), (5.0, 4.0, 1.2, 1.2, 2.4), (3, 5))
    ]
    flight, _ = explored(room((7.0, 6.0, 2.4), boxes), (1.2, 3.0, 1.2))
    assert (flight.kinds[reachable(flight)] == FREE).all()


@settings(max_examples=settings.default.max_examples // 10)
@given(st.integers(0, 2**32 - 1))
def test_the_way_home_is_always_known_and_keeps_the_clearance(seed):
    """In two drawn rooms with a door and boxes: at each view a path leads home, through free voxels only."""
    rng = np.random.default_rng(seed)
    door, half = rng.uniform(0.6, 2.6), rng.uniform(0.6, 0.9)
    wall = [((3.4, 0.0, 0.0), (3.6, door, 2.4)), ((3.4, door + 2 * half, 0.0), (3.6, 4.6, 2.4))]
    boxes = [
        ((x, y, 0.0), (x + w, y + d, h))
        for x, y, w, d, h in rng.uniform((4.4, 0.4, 0.4, 0.4, 0.4), (6.0, 3.6, 1.0, 1.0, 2.4), (2, 5))
    ]
    flight = Flight(room((7.4, 4.6, 2.4), wall + boxes), (1.3, 1.3, 1.2))
    explorer = Explorer(ExplorerParameters(**LIDAR))
    for _ in range(100):
        decision = explorer.decide(flight.space(), flight.place_m)
        if decision.goal_m is None:
            break
        flight.fly_to(decision.goal_m)
        home = flight.planner.plan(flight.place_m, flight.places_m[0])
        assert math.dist(home.points_m[-1], flight.places_m[0]) < 1e-9
        assert keeps_clearance(flight, home.points_m)
    assert decision.goal_m is None
    assert not decision.is_shut_in


def keeps_clearance(flight, points_m):
    """Whether a path runs through voxels that are known to be free, as far from others as it must be.

    Where the UAV itself is nearer at its begin, the path may be so, too, until it is clear.
    """
    far_m = ndimage.distance_transform_edt(flight.kinds == FREE) * SIDE_M
    passed_m = far_m[tuple(voxels_on(points_m, SIDE_M).T)]
    is_clear = passed_m >= PLANNER.clearance_m - 1e-9
    return bool((passed_m > 0.0).all() and is_clear[np.argmax(is_clear) :].all())


@pytest.mark.table(("way_spacing", "passes"), [(0.0, False), (0.4, True)])
def test_a_door_between_places_to_look_from_is_passed_on_closer_places(way_spacing, passes):
    """It leaves two voxels for the UAV's centre, 0.4 m, and places 0.8 m apart lie beside them."""
    wall = [((3.0, 0.0, 0.0), (3.2, 1.6, 2.4)), ((3.0, 2.4, 0.0), (3.2, 4.6, 2.4))]
    flight = Flight(room((6.2, 4.6, 2.4), wall), (1.3, 1.3, 1.2))
    asked = ExplorerParameters(**{**LIDAR, "spacing": 0.8}, way_spacing=way_spacing)
    flight.explore(Explorer(asked))
    assert bool(max(place[0] for place in flight.places_m) > 3.4) is passes


def test_what_no_beam_shows_is_named():
    """A lidar of one ring knows one layer, and the explorer says why the rest stays unknown."""
    flight = Flight(room((5.0, 5.0, 4.0)), (1.5, 1.5, 1.2), directions=beams(rings=1, elevation_rad=0.0))
    level = ExplorerParameters(**LIDAR, elevation_min=0.0, elevation_max=0.0)
    explorer = Explorer(level)
    decision, _ = flight.explore(explorer)
    assert decision.goal_m is None
    assert left_over(explorer, flight) or decision.is_shut_in


def test_a_slit_that_the_uav_does_not_fit_through_is_named():
    wall = [((3.0, 0.0, 0.0), (3.2, 2.2, 2.4)), ((3.0, 2.4, 0.0), (3.2, 5.0, 2.4))]
    flight = Flight(room((8.0, 5.0, 2.4), wall), (1.3, 1.3, 1.2))
    explorer = Explorer(ExplorerParameters(**LIDAR))
    flight.explore(explorer)
    behind = [left for left in left_over(explorer, flight) if left.place_m[0] > 3.4]
    assert sum(left.area_m2 for left in behind) > 1.0
    assert {left.why for left in behind} <= {Why.NO_ROOM, Why.NO_BEAM, Why.IN_VAIN, Why.SMALL}
    assert max(place[0] for place in flight.places_m) < 3.0


@pytest.mark.long
@pytest.mark.table("landmark_reach", [1.4, 0.0])
def test_what_is_seen_only_from_far_off_the_walls_is_named(landmark_reach):
    """From 1.4 m off the walls a lidar that sees 2.4 m does not see the middle of a room of 10 m."""
    keeps_near = dataclasses.replace(PLANNER, landmark_reach=landmark_reach)
    flight = Flight(room((10.0, 10.0, 2.4)), (1.2, 1.2, 1.2), sees_m=2.4, parameters=keeps_near)
    explorer = Explorer(ExplorerParameters(spacing=0.4, reach=2.4))
    flight.explore(explorer)
    far = [left for left in left_over(explorer, flight) if left.why is Why.FAR]
    assert (sum(left.area_m2 for left in far) > 5.0) is (landmark_reach > 0.0)
    assert all(min_off_walls([left.place_m], 10.0) > 3.0 for left in far)
    stays_near = bool(min_off_walls(flight.places_m, 10.0).max() < 1.4 + 2 * SIDE_M)
    assert stays_near is (landmark_reach > 0.0)


def min_off_walls(places_m, side_m):
    """How far each place (x, y, z) is from the nearest wall of a square room, m."""
    level = np.array(places_m)[:, :2]
    return np.minimum(level, side_m - level).min(axis=1)


def test_a_uav_that_fits_nowhere_is_shut_in_and_nothing_is_said_to_be_explored():
    flight = Flight(room((2.0, 2.0, 2.0)), (1.0, 1.0, 1.0))
    flight.kinds[:] = np.where(flight.kinds == FREE, UNKNOWN, flight.kinds)
    flight.kinds[5, 5, 5] = FREE
    flight.planner.update_map(SIDE_M, TILE, np.zeros((1, 3), int), flight.kinds.reshape(1, -1))
    decision = Explorer(ExplorerParameters(**LIDAR)).decide(flight.space(), flight.place_m)
    assert decision.is_shut_in
    assert decision.goal_m is None
