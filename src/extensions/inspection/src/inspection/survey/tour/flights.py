"""A short tour of all photographs (travelling salesman), and its cuts into flights that fit the battery."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_basics.errors import SurveyError
from inspection.survey.kernels.tours import (
    length_of,
    nearest_neighbour,
    one_tree_bound,
    perturb,
    shorten,
)
from inspection.survey.parameters import FlightParameters

NEAR = 50
"""Greatest length of the parts that are exchanged."""
BOUND_STEPS = 400


@dataclass(frozen=True)
class Tour:
    """A closed tour over all places; the first is home.

    order: (n,) places, home first. time_s, bound_s: of its legs, and the Held-Karp bound of every such tour.
    nearest_s: of the nearest-neighbour tour.
    """

    order: np.ndarray
    time_s: float
    bound_s: float
    nearest_s: float


def short_tour(times_s: np.ndarray, rng: np.random.Generator, tries: int, settled: int = 0) -> Tour:
    """Return a short tour by the times (n, n) of its legs.

    tries: perturbations. settled: so many places after home come first, in their order.
    """
    from_home_s, from_last_s = times_s[0, settled + 1 :], times_s[settled, settled + 1 :]
    # The settled places and home are one place: a tour leaves it from the last, and comes back to home. With
    # the mean of both a tour costs as much as it does on average over its two directions.
    costs_s = _joined(times_s, settled, 0.5 * (from_home_s + from_last_s))
    first = nearest_neighbour(costs_s, 0)
    order = first.copy()
    shorten(costs_s, order)
    order = _whole(times_s, settled, perturb(costs_s, order, rng.random((tries, 3)), NEAR))
    time_s = float(length_of(times_s, order))
    least_s = _joined(times_s, settled, np.minimum(from_home_s, from_last_s))
    settled_s = float(times_s[np.arange(settled), np.arange(1, settled + 1)].sum())
    bound_s = min(settled_s + float(one_tree_bound(least_s, time_s - settled_s, BOUND_STEPS)), time_s)
    return Tour(order, time_s, bound_s, float(length_of(times_s, _whole(times_s, settled, first))))


def _joined(times_s: np.ndarray, settled: int, own_s: np.ndarray) -> np.ndarray:
    """Return the times of home, which has its own (n - settled - 1,), and of what is not settled."""
    rest_s = times_s[settled:, settled:].copy()
    rest_s[0, 1:] = rest_s[1:, 0] = own_s
    return rest_s


def _whole(times_s: np.ndarray, settled: int, tour: np.ndarray) -> np.ndarray:
    """Return the order of all places, home first, in the shorter direction of a tour of the joined ones."""
    rest = np.roll(tour, -int(np.flatnonzero(tour == 0)[0]))[1:] + settled
    orders = [np.concatenate((np.arange(settled + 1), each)) for each in (rest, rest[::-1])]
    onward_s, backward_s = (float(length_of(times_s, each)) for each in orders)
    return orders[0] if not settled or onward_s <= backward_s else orders[1]


def flights_of(
    tour: Tour, times_s: np.ndarray, stays_s: float, flight: FlightParameters, settled: int = 0
) -> list[np.ndarray]:
    """Return the photographs (without home) of each flight: as few flights as the tour's order allows.

    stays_s: time at each photograph. settled: as of the tour; their flights keep its order. Of
    equally many flights those with the least time win (Prins, 2004).

    Raises:
        SurveyError: one photograph is too far for a battery.
    """
    order, most_s = tour.order[1:], flight.flight_s
    count = len(order)
    costs: list[tuple[int, float]] = [(0, 0.0)] + [(count + 1, np.inf)] * count
    begins = np.zeros(count + 1, np.int64)
    for i in range(count):
        if costs[i][0] > count:
            continue
        time_s = flight.landing_time + times_s[0, order[i]] + stays_s
        for j in range(i, count):
            if j > i:
                time_s += times_s[order[j - 1], order[j]] + stays_s
            home_s = times_s[order[j], 0]
            if time_s + flight.way_home_margin * home_s + flight.landing_time > most_s:
                break
            cost = (costs[i][0] + 1, costs[i][1] + time_s + home_s + flight.landing_time)
            if cost < costs[j + 1]:
                costs[j + 1], begins[j + 1] = cost, i
    if costs[count][0] > count:
        raise SurveyError(
            "A photograph is too far from home for one battery: give a longer endurance, a greater speed or "
            "another home."
        )
    flights, end = [], count
    while end:
        part = order[begins[end] : end]
        flights.append(part if part[0] <= settled else _improved(part, times_s))
        end = int(begins[end])
    return flights[::-1]


def _improved(part: np.ndarray, times_s: np.ndarray) -> np.ndarray:
    own = np.concatenate(([0], part))
    costs = np.ascontiguousarray(times_s[np.ix_(own, own)])
    order = np.arange(len(own))
    shorten(costs, order)
    return own[np.roll(order, -int(np.flatnonzero(order == 0)[0]))[1:]]


def flight_time_s(part: np.ndarray, times_s: np.ndarray, stays_s: float, flight: FlightParameters) -> float:
    """Return the time of one flight, take-off and landing in it."""
    own = np.concatenate(([0], part))
    return float(length_of(times_s, own)) + stays_s * len(part) + 2.0 * flight.landing_time
