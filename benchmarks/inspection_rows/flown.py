"""A plan, or its first photographs, flown without ROS and judged by the true poses."""

from __future__ import annotations

import math

import numpy as np

from benchmarks.inspection_rows.hold import FLYING, HOME_M, WORLD
from benchmarks.inspection_rows.parts import only
from exploration.energy import EnergyWatch
from exploration.planning import PlannerParameters
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Outcome, PhaseLimits
from flights.flight.parameters import LED_CEPA, ClosedLoopParameters
from flights.inspecting.flight import InspectingFlight, Photographed, controller_of, regulator
from gridslam.volume import VolumeParameters
from inspection.flight import InspectionParameters, PriorMap
from inspection.survey.coverage import coverages_on
from inspection.survey.parameters import FlightParameters
from inspection.survey.plan import SurveyPlan
from inspection.survey.planner import SurveyPlanner
from inspection.survey.poses import PhotographPose
from inspection.survey.supplement import Supplement
from inspection.survey.surface.reading import Surface, read_surface
from simulation_tools.camera.defects import decals_of
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.camera.renderer import Renderer
from simulation_tools.camera.surfaces import surfaces_of
from simulation_tools.geometry import Pose
from simulation_tools.sdf.parser import load_world
from simulation_tools.simulation import SimulationParameters
from simulation_tools.vehicle.energy.battery import BatteryStart

SEEDS, MOST, BRIEF_MOST = (31, 32, 33), 20, 1
SEARCH_S, BRIEF_SEARCH_S = 20.0, 0.0
PROGRESS = 25
"""After so many photographs a flight of the whole plan prints a line."""
FLIGHT_S, EACH_S = 300.0, 15.0
"""A flight may last so long, and so much longer for each photograph."""
PLANNER = PlannerParameters(radius=0.35, margin=0.05)
VOLUME = VolumeParameters(resolution_m=0.2, max_range_m=20.0, miss=0.46)
SPEED_M_S = 1.5
SWAPS = 20


def fly(seed: int, most: int, battery: bool, passing: bool) -> dict:
    """Fly the first photographs of a plan, or all, and judge what they show.

    battery: whether it counts. passing: photographs are taken in passing.
    """
    surface = read_surface(WORLD, FLYING, HOME_M)
    flying = FlightParameters(passing=passing)
    planner = SurveyPlanner(
        surface.room, surface.patches, surface.ranges_m, asked=FLYING, flying=flying, source=str(WORLD)
    )
    if most:
        first = next(planner.improve(seed, BRIEF_SEARCH_S, bound=False)).plan
        part = only(first, first.views[:most])
    else:
        *_, part = (each.plan for each in planner.improve(seed, SEARCH_S, bound=False))
    simulation = SimulationParameters(
        str(WORLD), lidar="puck", sensors=("range_finder", "range_finder_up"), gnss=False, seed=seed,
        spawn_pose=Pose((*HOME_M[:2], 0.0)), battery=BatteryStart() if battery else None,
    )  # fmt: skip
    parameters = ClosedLoopParameters(
        simulation, goal_xyz_m=None, algorithm="dynamic", range_finders=True, pose_source="odometry",
        limits=PhaseLimits(flight_timeout_s=FLIGHT_S + EACH_S * len(part.views)),
        position_controller=controller_of(SPEED_M_S), yaw_regulator=regulator(), cepa=LED_CEPA,
    )  # fmt: skip
    surfaces = surfaces_of(load_world(str(WORLD)))
    renderer = Renderer(surfaces, decals_of((), surfaces), CameraOptics())
    with ClosedLoop(parameters) as loop:
        prior = PriorMap(surface.room)
        watch = EnergyWatch() if battery else None
        more = None if most else Supplement(part, surface)
        flight = InspectingFlight(
            loop, part, renderer, PLANNER, VOLUME, InspectionParameters(), prior, watch, SWAPS, more
        )
        if not most:
            flight.on_photograph = lambda: _tell(seed, flight, loop)
        photographed, outcome = flight.run(), loop.outcome
    return _flown_row(flight, photographed, outcome, part, surface)


def _tell(seed: int, flight: InspectingFlight, loop: ClosedLoop) -> None:
    queue, taken = flight.inspection.queue, len(flight.photographed.true)
    if taken % PROGRESS == 0:
        print(
            f"seed {seed}: {loop.time_s:.0f} s, {taken} photographs, {len(queue.open)} open, "
            f"{len(queue.left_out)} left out, charge {loop.charge:.2f}",
            flush=True,
        )


def _flown_row(
    flight: InspectingFlight, photographed: Photographed, outcome: Outcome, part: SurveyPlan, surface: Surface
) -> dict:
    """Judge a flight of a plan by the true poses."""
    planned = [PhotographPose.of_view(each) for each in part.views]
    shown, by_plan = coverages_on(surface, (photographed.true, planned), part.camera, FLYING)
    off = [a.axes @ b.axes.T for a, b in zip(photographed.true, photographed.estimated)]
    turned_deg = [math.degrees(math.acos(min(1.0, 0.5 * (np.trace(each) - 1.0)))) for each in off]
    off_m = [np.linalg.norm(a.place_m - b.place_m) for a, b in zip(photographed.true, photographed.estimated)]
    return {
        "asked": len(part.views),
        "taken": len(photographed.true),
        "left_out": len(flight.inspection.queue.left_out),
        "shots": photographed.shots,
        "contacts": outcome.collision,
        "landed": outcome.landed,
        "flights": len(photographed.flights),
        "least_charge": min(flight.landed_at, default=math.nan),
        "share_of_planned": shown.shown_m2 / by_plan.shown_m2,
        "share_planned": by_plan.share(),
        "share": shown.share(),
        "shares": {name: shown.share(number) for number, name in enumerate(shown.patches.names)},
        "m2_per_min": 60.0 * shown.shown_m2 / photographed.flight_s,
        "each_s": photographed.flight_s / len(photographed.true),
        "flight_s": photographed.flight_s,
        "off_m": float(np.median(off_m)),
        "off_deg": float(np.median(turned_deg)),
    }
