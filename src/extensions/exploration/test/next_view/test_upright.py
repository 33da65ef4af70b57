"""Steep legs of a way lead straight up or down, and then level."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from voxel_room import PLANNER, SIDE_M

from exploration.next_view import ExplorationParameters, ExplorerParameters
from exploration.next_view.guide import Guide
from exploration.next_view.upright import ASIDE_M, RISE_M, STEEPER, upright
from exploration.planning import FREE, OCCUPIED, PathPlanner

SLOPES = ExplorerParameters().slopes


def anywhere(begin_m, end_m):
    return math.dist(begin_m, end_m)


def is_steep(begin_m, end_m):
    aside_m, rise_m = math.dist(begin_m[:2], end_m[:2]), abs(end_m[2] - begin_m[2])
    return aside_m > ASIDE_M and rise_m > RISE_M and rise_m > STEEPER * math.tan(math.radians(15)) * aside_m


@given(st.integers(2, 6), st.integers(0, 2**32 - 1))
def test_no_leg_is_steep_where_all_is_clear_and_every_place_is_kept(count, seed):
    places_m = list(np.random.default_rng(seed).uniform(0.0, 9.0, (count, 3)))
    way_m = upright(places_m, SLOPES, anywhere)
    assert not any(map(is_steep, way_m, way_m[1:]))
    kept = iter(way_m)
    assert all(any(place_m is there_m for there_m in kept) for place_m in places_m)
    steep = sum(map(is_steep, places_m, places_m[1:]))
    assert len(way_m) == count + steep


@given(st.integers(0, 2**32 - 1))
def test_a_leg_leads_only_over_what_is_clear(seed):
    rng = np.random.default_rng(seed)
    begin_m, end_m = rng.uniform(0.0, 9.0, (2, 3))
    closed = rng.random(2) < 0.5  # over the beginning, over the end

    def cost_m(a_m, b_m):
        is_first = any(np.array_equal(m, (*begin_m[:2], end_m[2])) for m in (a_m, b_m))
        return math.inf if closed[0 if is_first else 1] else math.dist(a_m, b_m)

    way_m = upright([begin_m, end_m], SLOPES, cost_m)
    assert all(math.isfinite(cost_m(a, b)) for a, b in zip(way_m, way_m[1:])) or len(way_m) == 2
    assert (len(way_m) == 3) == (is_steep(begin_m, end_m) and not closed.all())


def led(filled, has_range_finders=True):
    """The first setpoint of a way that leads 5 m up and 4 m ahead, and the places after it."""
    kinds = np.full((40, 40, 40), FREE, np.uint8)
    kinds[filled] = OCCUPIED
    planner = PathPlanner(PLANNER)
    planner.update_map(SIDE_M, 40, np.zeros((1, 3), int), kinds.reshape(1, -1))
    guide = Guide(planner, ExplorationParameters(steep=has_range_finders), SLOPES)
    assert guide.plan(np.array((2.1, 4.1, 1.5)), np.array((6.1, 4.1, 6.5)), 0.0)
    return guide.way.rest_m


def test_the_uav_is_led_straight_up_and_then_ahead():
    rest_m = led(np.s_[:0])
    np.testing.assert_allclose(rest_m[0][:2], (2.1, 4.1))
    np.testing.assert_allclose(rest_m[-2:], [(2.1, 4.1, 6.5), (6.1, 4.1, 6.5)])


def test_without_range_finders_it_is_led_there_straight():
    assert len(led(np.s_[:0], has_range_finders=False)) < len(led(np.s_[:0]))


def test_under_a_deck_it_is_led_ahead_first():
    deck = (slice(20, 21), slice(None), slice(0, 22))  # at z = 4 m, up to x = 4.4 m
    way_m = [np.array((2.1, 4.1, 1.5)), *led(deck)]
    legs = [b - a for a, b in zip(way_m, way_m[1:]) if b[2] - a[2] > RISE_M]
    assert legs
    assert all(math.hypot(*leg[:2]) < ASIDE_M + 0.2 or not is_steep(np.zeros(3), leg) for leg in legs)
