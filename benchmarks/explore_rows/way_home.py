"""The way home as it was reckoned when the UAV turned back, beside the time that it took.

The seed draws the place, and after how long the UAV turns back. The battery is full, so that only the time
ends the exploration.
"""

from __future__ import annotations

import math
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Sequence

import numpy as np

from benchmarks.explore_rows.batteries import ENERGY, PLACES
from exploration.energy import EnergyWatch
from master_thesis.exploring.flight import ExploringFlight
from master_thesis.exploring.places import place_of
from master_thesis.flight.closed_loop import ClosedLoop
from master_thesis.flight.course import Phase
from simulation_tools.vehicle.energy.battery import BatteryStart

ROW = "way_home"
SEEDS = tuple(range(2001, 2021))
TIME_S, LONGEST_S = (15.0, 40.0), 200.0
"""The UAV turns back after a time between these; after the third it lands where it is."""
SHORTEST_M = 2.0
"""A shorter way says little: what counts there is how long the UAV takes to settle over its home."""


def fly(seed: int) -> dict:
    """Explore a place for a while and come home; return times in s and the planned length in m."""
    rng = np.random.default_rng(seed)
    place = place_of(PLACES[seed % len(PLACES)], seed)
    asked = place.asked(float(rng.uniform(*TIME_S)))
    with tempfile.TemporaryDirectory() as folder:
        given = place.loop_parameters(place.written_to(Path(folder)), seed, LONGEST_S)
        given = replace(given, simulation=replace(given.simulation, battery=BatteryStart()))
        with ClosedLoop(given) as loop:
            energy = EnergyWatch(ENERGY)
            flight = ExploringFlight(loop, place.planner, place.explorer, place.volume, asked, energy)
            told, outcome = flight.run(), loop.outcome
    way = told.way_home
    return {
        "place": PLACES[seed % len(PLACES)],
        "ended": told.end.value if told.end else "",
        "landed": outcome.landed,
        "contact": outcome.collision,
        "reckoned_m": way.length_m if way else math.nan,
        "reckoned_s": way.time_s if way else math.nan,
        "flown_s": outcome.times_s.get(Phase.HOVERING, math.nan) - told.ended_s,
    }


def summary(flights: Sequence[dict]) -> dict:
    """Return how many ways took longer than the energy watch allows for, and the ratios flown to reckoned.

    It allows for `margin` times the reckoned time, and for the landing. A UAV that did not come home counts
    as one that took longer.
    """
    ratios = [f["flown_s"] / f["reckoned_s"] for f in flights if f["reckoned_m"] >= SHORTEST_M]
    known = [ratio for ratio in ratios if math.isfinite(ratio)]
    allowed = [ENERGY.margin * f["reckoned_s"] + ENERGY.landing_time for f in flights]
    return {
        "flights": len(flights),
        "longer_than_allowed": sum(not f["flown_s"] <= most for f, most in zip(flights, allowed)),
        "ways": len(ratios),
        "ratio_median": float(np.median(known)) if known else math.nan,
        "ratio_99": float(np.quantile(known, 0.99)) if known else math.nan,
        "ratio_greatest": max(known, default=math.nan),
        "longest_m": max((f["reckoned_m"] for f in flights), default=math.nan),
        "contacts": sum(f["contact"] for f in flights),
    }
