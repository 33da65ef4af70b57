"""A short tour of all photographs, and its cuts into flights that fit the battery."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from inspection_tools.errors import SurveyError
from inspection_tools.survey.kernels.tours import (
    length_of,
    nearest_neighbour,
    one_tree_bound,
    perturb,
    shorten,
)
from inspection_tools.survey.parameters import FlightParameters

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


def short_tour(times_s: np.ndarray, rng: np.random.Generator, tries: int) -> Tour:
    """Return a short tour by the times (n, n) of its legs. tries: perturbations."""
    first = nearest_neighbour(times_s, 0)
    order = first.copy()
    shorten(times_s, order)
    order = perturb(times_s, order, rng.random((tries, 3)), NEAR)
    time_s = float(length_of(times_s, order))
    bound_s = min(float(one_tree_bound(times_s, time_s, BOUND_STEPS)), time_s)
    home = int(np.flatnonzero(order == 0)[0])
    return Tour(np.roll(order, -home), time_s, bound_s, float(length_of(times_s, first)))


def flights_of(tour: Tour, times_s: np.ndarray, stays_s: float, flight: FlightParameters) -> list[np.ndarray]:
    """Return the photographs (without home) of each flight: as few flights as the tour's order allows.

    stays_s: time at each photograph. Of equally many flights those with the least time win (Prins, 2004).

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
        flights.append(_improved(order[begins[end] : end], times_s))
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
