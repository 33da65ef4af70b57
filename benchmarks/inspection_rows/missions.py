"""Missions whose battery is too small for their photographs: the UAV comes home in time, and goes on.

The seed draws rooms, the first battery's charge and temperature, and a wind. The photographs are the first of
a plan on the rooms' drawing. Flown with dynamics and without GNSS, and no pixel is rendered.
"""

from __future__ import annotations

import math
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Sequence

import numpy as np

from benchmarks.inspection_rows.hold import FLYING
from benchmarks.inspection_rows.parts import only
from exploration.energy import EnergyWatch
from flights.exploring.places import SMALL_ROOMS, Place, place_of
from flights.flight.closed_loop import ClosedLoop
from flights.flight.conditions import Conditions
from flights.flight.parameters import ClosedLoopParameters
from flights.inspecting.flight import InspectingFlight, controller_of, regulator
from inspection.flight import InspectionParameters, PriorMap
from inspection.survey.plan import SurveyPlan
from inspection.survey.planner import SurveyPlanner
from inspection.survey.surface.reading import read_surface
from inspection.survey.surface.room import Room
from simulation_tools.camera.defects import decals_of
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.camera.renderer import Renderer
from simulation_tools.camera.surfaces import surfaces_of
from simulation_tools.sdf.parser import load_world
from simulation_tools.vehicle.energy.battery import COLDEST_C, WARM_C, BatteryStart

SEEDS = range(2101, 2301)
"""The row was developed with seeds below 10."""
MOST, BRIEF_MOST = 30, 2
"""Photographs of a mission."""
CHARGE = 0.18, 0.25
"""At the start. The take-off takes some 2 %, 12 % are the reserve."""
WIND_M_S = 0.0, 3.0
SWAPS, LONGEST_S = 2, 400.0
HEIGHT_M, SPEED_M_S = 1.5, 1.5
"""Of the hover above home; between photographs."""
HOME_M = 1.0
"""A UAV lands at home if it is so near."""
GOAL = 0.10


def fly(seed: int, most: int) -> dict:
    """Fly a mission; return its metrics. Charges are shares of what the cold battery gives."""
    rng = np.random.default_rng(seed)
    place = place_of(SMALL_ROOMS, seed)
    start = BatteryStart(float(rng.uniform(*CHARGE)), float(rng.uniform(COLDEST_C, WARM_C)))
    wind_m_s = float(rng.uniform(*WIND_M_S))
    with tempfile.TemporaryDirectory() as folder:
        world = place.written_to(Path(folder))
        plan, room = _planned(world, place, seed, most)
        surfaces = surfaces_of(load_world(str(world)))
        renderer = Renderer(surfaces, decals_of((), surfaces), CameraOptics())
        with ClosedLoop(_parameters(place, world, seed, start, wind_m_s)) as loop:
            flight = InspectingFlight(
                loop, plan, renderer, place.planner, place.volume, InspectionParameters(), PriorMap(room),
                EnergyWatch(), SWAPS,
            )  # fmt: skip
            photographed, outcome = flight.run(), loop.outcome
            x, y, *_ = loop.log.truth.rows[-1][1:]
    queue = flight.inspection.queue
    return {
        "charge": start.charge,
        "capacity": start.capacity_share,
        "wind_m_s": wind_m_s,
        "contact": outcome.collision,
        "landed": outcome.landed,
        "failure": outcome.failure or "",
        "end": flight.inspection.end.value if flight.inspection.end else "",
        "landed_at": flight.landed_at,
        "off_home_m": math.dist((x, y), place.start_m[:2]),
        "asked": len(plan.views),
        "taken": len(photographed.true),
        "left_out": len(queue.left_out),
        "open": len(queue.open),
        "flight_s": photographed.flight_s,
    }


def _planned(world: Path, place: Place, seed: int, most: int) -> tuple[SurveyPlan, Room]:
    x, y, z = place.start_m
    surface = read_surface(world, FLYING, (x, y, z + HEIGHT_M))
    planner = SurveyPlanner(surface.room, surface.patches, surface.ranges_m, asked=FLYING, source=str(world))
    whole = next(planner.improve(seed, 0.0, bound=False)).plan
    return only(whole, whole.views[:most]), surface.room


def _parameters(
    place: Place, world: Path, seed: int, start: BatteryStart, wind_m_s: float
) -> ClosedLoopParameters:
    given = place.loop_parameters(world, seed, LONGEST_S)
    return replace(
        given,
        simulation=replace(given.simulation, battery=start),
        conditions=Conditions(wind_m_s=wind_m_s),
        position_controller=controller_of(SPEED_M_S),
        yaw_regulator=regulator(),
    )


def summary(missions: Sequence[dict]) -> dict:
    """Return how the missions ended. lost: photographs that are neither taken nor open nor left out."""
    charges = [charge for mission in missions for charge in mission["landed_at"]]
    count = {key: sum(mission[key] for mission in missions) for key in ("asked", "taken", "left_out", "open")}
    return {
        "missions": len(missions),
        "landings": len(charges),
        "below_goal": sum(charge < GOAL for charge in charges),
        "least_charge": min(charges, default=math.nan),
        "contacts": sum(mission["contact"] for mission in missions),
        "not_home": sum(
            not mission["landed"] or bool(mission["failure"]) or mission["off_home_m"] > HOME_M
            for mission in missions
        ),
        **count,
        "lost": count["asked"] - count["taken"] - count["left_out"] - count["open"],
    }
