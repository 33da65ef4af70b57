"""A UAV takes a photograph with dynamics, without GNSS, and comes home."""

import math
from dataclasses import replace

import numpy as np
import pytest

from gridslam.volume import VolumeParameters
from inspection_tools.inspection import End, InspectionParameters
from inspection_tools.planning import PlannerParameters
from inspection_tools.survey import FlightParameters, SurveyCamera, SurveyParameters
from inspection_tools.survey.plan import Flight, PlannedView, SurveyPlan
from inspection_tools.survey.views.candidates import View
from master_thesis.experiments_3_4.mapping_flight import parameters_of
from master_thesis.flight.closed_loop import ClosedLoop
from master_thesis.flight.course import PhaseLimits
from master_thesis.inspecting.flight import InspectingFlight
from simulation_tools.camera.defects import decals_of
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.camera.renderer import Renderer
from simulation_tools.camera.surfaces import surfaces_of
from simulation_tools.sdf.parser import load_world

pytestmark = pytest.mark.flight


def test_it_photographs_from_its_place_and_lands_at_home():
    given = parameters_of("room", "puck", 2)
    simulation = replace(given.simulation, sensors=("range_finder",), gnss=False)
    x, y, _ = simulation.spawn_pose.position_m
    view = View((x + 1.0, y, 1.5), 0.5 * math.pi, 0.2)
    flight = Flight((PlannedView(view),), 10.0, 2.0)
    plan = SurveyPlan("", (x, y, 1.5), SurveyCamera(), SurveyParameters(), FlightParameters(), (flight,))
    parameters = replace(
        given, simulation=simulation, mission=(), goal_xyz_m=None, pose_source="odometry",
        limits=PhaseLimits(flight_timeout_s=60.0),
    )  # fmt: skip
    surfaces = surfaces_of(load_world(simulation.world))
    renderer = Renderer(surfaces, decals_of((), surfaces), CameraOptics())
    with ClosedLoop(parameters) as loop:
        flown = InspectingFlight(
            loop, plan, renderer, PlannerParameters(radius=0.35, margin=0.1), VolumeParameters(0.2),
            InspectionParameters(),
        )  # fmt: skip
        photographed, outcome = flown.run(), loop.outcome
        truth = loop.log.truth.array("x_m", "y_m")
    assert flown.inspection.end is End.DONE
    assert outcome.landed
    assert not outcome.collision
    assert math.dist(truth[0], truth[-1]) < 0.8
    (true,), (told,) = photographed.true, photographed.told
    assert np.linalg.norm(true.place_m - view.place_m) < 0.5
    assert np.linalg.norm(true.place_m - told.place_m) < 0.1
    ahead = (0.0, math.cos(0.2), math.sin(0.2))
    assert true.axes[:, 2] @ ahead > math.cos(math.radians(3.0))
    assert told.axes[:, 2] @ ahead > math.cos(math.radians(3.0))
