"""Missions whose battery is too small for the place: the UAV comes home in time.

The seed draws the place, the battery's charge and temperature, a wind, and how SLAM's pose drifts until
closed loops move the map.
"""

from __future__ import annotations

import math
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Sequence

import numpy as np

from exploration.energy import EnergyParameters, EnergyWatch
from flights.exploring.drift import Drift
from flights.exploring.flight import ExploringFlight
from flights.exploring.places import SMALL_ROOMS, place_of
from flights.flight.closed_loop import ClosedLoop
from flights.flight.conditions import Conditions
from simulation_tools.vehicle.energy.battery import COLDEST_C, WARM_C, BatteryStart

ROW = "batteries"
PLACES = (SMALL_ROOMS, "cells", "u_shape", "snake")
CHARGE = 0.20, 0.25
"""At the start. The take-off takes some 2 %, 15 % are the reserve, and 10 s take 1.5 to 2.5 %."""
ENERGY = EnergyParameters(reserve=0.15)
"""As explorer.launch has it."""
SWAPS_EACH = 4
"""Every so many missions get a full battery and go on."""
WIND_M_S = 0.0, 3.0
LOOP_S, FAR_M, TURN_RAD = (6.0, 15.0), 0.4, math.radians(2.0)
"""Time between two closed loops, and how far they move the map at most."""
TIME_S, LONGEST_S = 30.0, 300.0
"""For each battery; for the whole mission."""
HOME_M = 1.5
"""A UAV lands at home if it is so near, with the drift of its pose."""
GOAL = 0.10


def fly(seed: int) -> dict:
    """Fly a mission; return its metrics. Charges are shares of what the cold battery gives."""
    rng = np.random.default_rng(seed)
    place = place_of(PLACES[seed % len(PLACES)], seed)
    start = BatteryStart(float(rng.uniform(*CHARGE)), float(rng.uniform(COLDEST_C, WARM_C)))
    wind_m_s = float(rng.uniform(*WIND_M_S))
    drift = Drift.drawn(rng, LOOP_S, FAR_M, TURN_RAD, LONGEST_S)
    asked = place.asked(TIME_S)
    swaps = int(seed % (SWAPS_EACH * len(PLACES)) < len(PLACES))
    with tempfile.TemporaryDirectory() as folder:
        given = place.loop_parameters(place.written_to(Path(folder)), seed, LONGEST_S)
        given = replace(
            given,
            simulation=replace(given.simulation, battery=start),
            conditions=Conditions(wind_m_s=wind_m_s),
        )
        with ClosedLoop(given) as loop:
            flight = ExploringFlight(
                loop, place.planner, place.explorer, place.volume, asked, EnergyWatch(ENERGY), swaps, drift
            )
            known_m3 = flight.run().known_m3
            outcome = loop.outcome
    landings = flight.landings
    return {
        "swaps": swaps,
        "place": PLACES[seed % len(PLACES)],
        "charge": start.charge,
        "capacity": start.capacity_share,
        "wind_m_s": wind_m_s,
        "contact": outcome.collision,
        "landed": outcome.landed,
        "failure": outcome.failure or "",
        "ends": [each.end for each in landings],
        "landed_at": [each.charge for each in landings],
        "off_home_m": [math.dist(each.place_m[:2], place.start_m[:2]) for each in landings],
        "reasons": [each.reason for each in landings],
        "known_m3": known_m3[-1][1] if known_m3 else 0.0,
    }


def summary(missions: Sequence[dict]) -> dict:
    """Return how the missions ended. least_charge: at any landing."""
    charges = [charge for mission in missions for charge in mission["landed_at"]]
    return {
        "missions": len(missions),
        "landings": len(charges),
        "came_home_for_energy": sum("battery" in mission["ends"] for mission in missions),
        "below_goal": sum(charge < GOAL for charge in charges),
        "least_charge": min(charges, default=math.nan),
        "median_charge": float(
            np.median([m["landed_at"][0] for m in missions if "battery" in m["ends"]] or [math.nan])
        ),
        "not_home": sum(
            not mission["landed"]
            or bool(mission["failure"])
            or max(mission["off_home_m"], default=math.inf) > HOME_M
            for mission in missions
        ),
        "contacts": sum(mission["contact"] for mission in missions),
    }
