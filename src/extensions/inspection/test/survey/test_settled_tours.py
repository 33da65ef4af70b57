"""A tour that begins with settled places keeps their order, and is near the best one for a few places."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inspection.survey.parameters import FlightParameters
from inspection.survey.tour.flights import flights_of, short_tour

OTHERS = 5


def times_between(seed, settled):
    """Of home, settled and other places, at 1 m/s."""
    places_m = 20.0 * np.random.default_rng(seed).random((1 + settled + OTHERS, 3))
    return np.linalg.norm(places_m[:, None] - places_m[None], axis=2)


def time_of(order, times_s):
    closed = [*order, order[0]]
    return sum(times_s[a, b] for a, b in zip(closed, closed[1:]))


@given(st.integers(0, 2**32 - 1), st.integers(0, 4))
def test_a_tour_goes_on_from_its_settled_places(seed, settled):
    times_s = times_between(seed, settled)
    tour = short_tour(times_s, np.random.default_rng(seed), 50, settled)
    assert tour.order[: settled + 1].tolist() == list(range(settled + 1))
    assert sorted(tour.order) == list(range(len(times_s)))
    assert tour.time_s == pytest.approx(time_of(tour.order, times_s))
    first, rest = range(settled + 1), range(settled + 1, len(times_s))
    best_s = min(time_of([*first, *others], times_s) for others in permutations(rest))
    assert tour.bound_s <= best_s + 1e-6
    assert best_s - 1e-6 <= tour.time_s <= 1.1 * best_s


@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_flights_keep_the_order_of_settled_places_and_fit_the_battery(seed, settled):
    times_s = times_between(seed, settled)
    flying = FlightParameters(endurance=130.0)
    tour = short_tour(times_s, np.random.default_rng(seed), 50, settled)
    flights = flights_of(tour, times_s, 2.0, flying, settled)
    flown = [place for flight in flights for place in flight.tolist()]
    assert flown[:settled] == list(range(1, settled + 1))
    assert sorted(flown) == list(range(1, len(times_s)))
    for flight in flights:
        way_s = time_of([0, *flight], times_s) + 2.0 * len(flight) + 2.0 * flying.landing_time
        assert way_s <= flying.flight_s + 1e-6
