"""Flights for given photographs: their order, the ways between them, and the cuts by the battery."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from inspection.survey.parameters import FlightParameters
from inspection.survey.plan import Flight, PlannedView
from inspection.survey.surface.room import Room
from inspection.survey.tour.flights import flight_time_s, flights_of, short_tour
from inspection.survey.tour.ways import Ways, leg_times_s
from inspection.survey.views.candidates import View

PASSING_S = 0.5
"""What a photograph in passing takes beyond `leg_times_s`: where the UAV flies on, it turns on an arc. In
hold_3d 40 photographs took 1.8 s each, by `leg_times_s` 1.35 s."""


def flown(
    room: Room,
    shots: Sequence[View],
    flying: FlightParameters,
    rng: np.random.Generator,
    tries: int,
    settled: int = 0,
) -> tuple[tuple[Flight, ...], dict[str, float]]:
    """Return the flights from the room's home, and figures of the tour.

    tries: perturbations of the tour. settled: so many of the shots come first, in their order.

    Raises:
        SurveyError: there is no way to a photograph, or not on one battery.
    """
    places_m = np.concatenate((room.home_m[None], np.array([shot.place_m for shot in shots])))
    yaws = np.array([0.0] + [shot.yaw_rad for shot in shots])
    tilts = np.array([0.0] + [shot.tilt_rad for shot in shots])
    ways = Ways(room, places_m)
    times_s = leg_times_s(ways.lengths_m, yaws, tilts, flying)
    stay_s = PASSING_S if flying.passing else flying.settle
    tour = short_tour(times_s, rng, tries, settled)
    flights = []
    for part in flights_of(tour, times_s, stay_s, flying, settled):
        legs = [(a, b) for a, b in zip([0, *part], part)]
        views = tuple(
            PlannedView(shots[b - 1], tuple(map(tuple, ways.between(a, b).round(3).tolist())))
            for a, b in legs
        )
        flights.append(Flight(views, flight_time_s(part, times_s, stay_s, flying), _length_m(ways, part)))
    stays_s = stay_s * len(shots)
    closed = np.append(tour.order, tour.order[0])
    figures = {
        "photographs": len(shots),
        "tour_m": float(ways.lengths_m[closed[:-1], closed[1:]].sum()),
        "tour_s": tour.time_s + stays_s,
        "tour_bound_s": tour.bound_s + stays_s,
        "tour_nearest_s": tour.nearest_s + stays_s,
    }
    return tuple(flights), figures


def _length_m(ways: Ways, part: np.ndarray) -> float:
    closed = [0, *part.tolist(), 0]
    return float(sum(ways.lengths_m[a, b] for a, b in zip(closed, closed[1:])))
