"""A UAV takes a photograph with dynamics, without GNSS, and comes home."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from exploration.energy import EnergyWatch
from exploration.planning import PlannerParameters
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import PhaseLimits
from flights.flight.parameters import LED_CEPA
from flights.inspecting.flight import InspectingFlight, controller_of, regulator
from flights.mapping.mapping_flight import parameters_of
from gridslam.volume import VolumeParameters
from inspection.flight import End, InspectionParameters, PriorMap
from inspection.survey import FlightParameters, SurveyCamera, SurveyParameters
from inspection.survey.coverage import coverages_on
from inspection.survey.plan import Flight, PlannedView, SurveyPlan
from inspection.survey.supplement import Supplement
from inspection.survey.surface.reading import read_surface
from inspection.survey.views.candidates import View
from simulation_tools.camera.defects import decals_of
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.camera.renderer import Renderer
from simulation_tools.camera.surfaces import surfaces_of
from simulation_tools.sdf.parser import load_world
from simulation_tools.vehicle.energy.battery import BatteryStart

pytestmark = pytest.mark.flight


def flight_in_a_room(charge=None):
    """A plan of one photograph, and the parameters of a flight. charge: of the battery; None: endless."""
    given = parameters_of("room", "puck", 2)
    battery = None if charge is None else BatteryStart(charge)
    simulation = replace(given.simulation, sensors=("range_finder",), gnss=False, battery=battery)
    x, y, _ = simulation.spawn_pose.position_m
    view = View((x + 1.0, y, 1.5), 0.5 * math.pi, 0.2)
    flight = Flight((PlannedView(view),), 10.0, 2.0)
    plan = SurveyPlan("", (x, y, 1.5), SurveyCamera(), SurveyParameters(), FlightParameters(), (flight,))
    parameters = replace(
        given, simulation=simulation, mission=(), goal_xyz_m=None, pose_source="odometry",
        limits=PhaseLimits(flight_timeout_s=90.0), position_controller=controller_of(1.0),
        yaw_regulator=regulator(), cepa=LED_CEPA,
    )  # fmt: skip
    return plan, parameters


def inspecting_flight(loop, plan, energy=None, swaps=0, prior=None, supplement=None):
    surfaces = surfaces_of(load_world(loop.parameters.simulation.world))
    renderer = Renderer(surfaces, decals_of((), surfaces), CameraOptics())
    planner = PlannerParameters(radius=0.35, margin=0.1)
    return InspectingFlight(
        loop, plan, renderer, planner, VolumeParameters(0.2), InspectionParameters(), prior, energy, swaps,
        supplement,
    )  # fmt: skip


@pytest.mark.long
def test_a_battery_that_runs_low_is_swapped_at_home_and_the_flight_goes_on():
    """At 14 % less the take-off, the reserve of 12 % says to come home before the first photograph."""
    plan, parameters = flight_in_a_room(charge=0.14)
    with ClosedLoop(parameters) as loop:
        flown = inspecting_flight(loop, plan, EnergyWatch(), swaps=1)
        photographed, outcome = flown.run(), loop.outcome
        charge = loop.simulation.power.battery.remaining
    assert [each.photographs for each in photographed.flights] == [0, 1]
    first_charge, last_charge = flown.landed_at
    assert 0.08 < first_charge < photographed.flights[0].charge < 0.14
    assert last_charge == charge > 0.9
    assert (len(photographed.true), outcome.landed, outcome.failure) == (1, True, None)


@pytest.mark.parametrize("is_supplemented", [False, pytest.param(True, marks=pytest.mark.long)])
def test_it_photographs_from_its_place_then_what_that_did_not_show_and_lands_at_home(is_supplemented):
    plan, parameters = flight_in_a_room()
    asked = SurveyParameters(resolution=4.0, share=0.2, class_share=0.0, margin=0.25, voxel=0.2, patch=1.0)
    plan = replace(plan, asked=asked)
    (view,) = plan.views
    parameters = replace(parameters, limits=PhaseLimits(flight_timeout_s=150.0))
    surface = read_surface(Path(parameters.simulation.world), asked, plan.home_m)
    supplement = Supplement(plan, surface) if is_supplemented else None
    with ClosedLoop(parameters) as loop:
        flown = inspecting_flight(loop, plan, prior=PriorMap(surface.room), supplement=supplement)
        photographed, outcome = flown.run(), loop.outcome
        truth = loop.log.truth.array("x_m", "y_m")
    assert (flown.inspection.end, outcome.landed, outcome.collision) == (End.DONE, True, False)
    assert math.dist(truth[0], truth[-1]) < 0.8
    first, *more = photographed.true
    estimated = photographed.estimated[0]
    assert np.linalg.norm(first.place_m - view.place_m) < 0.5
    assert np.linalg.norm(first.place_m - estimated.place_m) < 0.1
    ahead = (0.0, math.cos(0.2), math.sin(0.2))
    assert first.axes[:, 2] @ ahead > math.cos(math.radians(3.0))
    assert estimated.axes[:, 2] @ ahead > math.cos(math.radians(3.0))
    assert len(more) == len(flown.inspection.queue.tasks) - 1
    assert bool(more) == is_supplemented
    before, after = coverages_on(surface, ([first], photographed.true), plan.camera, asked)
    assert before.share() < asked.share
    assert (after.share() >= asked.share) == is_supplemented
