"""Views that show all cells, and in what order they are flown."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from voxel_room import Flight, room

from exploration.next_view import Explorer, ExplorerParameters
from exploration.next_view.roadmap import Roadmap
from exploration.next_view.views.tour import covering, first_of_tour, shortest_order


@given(st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_the_order_is_as_short_as_the_best_of_all_permutations(count, seed):
    rng = np.random.default_rng(seed)
    begins, ends, between = rng.random(count), rng.random(count), rng.random((count, count))

    def length(order):
        legs = sum(between[a, b] for a, b in zip(order, order[1:]))
        return begins[order[0]] + legs + ends[order[-1]]

    found = shortest_order(begins, between, ends)
    assert sorted(found) == list(range(count))
    least = min(length(order) for order in itertools.permutations(range(count)))
    np.testing.assert_allclose(length(found), least)


@given(st.integers(0, 2**32 - 1))
def test_the_chosen_views_show_every_cell_that_any_view_shows(seed):
    rng = np.random.default_rng(seed)
    sights = rng.random((12, 9)) < 0.2
    chosen = covering(sights, rng.random(12))
    assert (sights[chosen].any(axis=0) == sights.any(axis=0)).all()
    assert len(set(chosen.tolist())) == len(chosen) <= 9


@given(st.integers(0, 2**32 - 1))
def test_each_chosen_view_shows_most_of_what_is_still_open(seed):
    rng = np.random.default_rng(seed)
    sights, ways_m = rng.random((12, 9)) < 0.3, rng.random(12)
    open_cells = sights.any(axis=0)
    for view in covering(sights, ways_m):
        assert (sights[view] & open_cells).sum() == (sights & open_cells).sum(axis=1).max()
        open_cells &= ~sights[view]
    assert not open_cells.any()


def test_of_equal_views_the_nearer_one_is_chosen():
    sights = np.array([[True, True], [True, True], [False, True]])
    assert covering(sights, np.array([5.0, 2.0, 1.0])).tolist() == [1]


def test_what_is_near_is_seen_before_the_uav_flies_far_and_what_lies_on_the_way_home_at_last():
    flight = Flight(room((10.0, 3.0, 2.4)), (5.1, 1.3, 1.2))
    flight.explore(Explorer(ExplorerParameters(spacing=0.4, reach=8.0)))
    flight.fly_to((8.0, 1.3, 1.2))
    roadmap = Roadmap(flight.space(), flight.place_m, 2)
    east, west, home = (roadmap.nearest(np.array((x, 1.3, 1.2))) for x in (9.0, 6.0, 2.0))
    assert first_of_tour(roadmap, np.array([west, east]), np.array((2.0, 1.3, 1.2))) == east
    assert first_of_tour(roadmap, np.array([home, west, east]), np.array((5.1, 1.3, 1.2))) == east
    # And the ways between nodes are as long from the one end as from the other
    np.testing.assert_allclose(roadmap.ways_from(east)[west], roadmap.ways_from(west)[east])
