"""What is computed after a flight, from its log and the world's file: clearances and the floor plan."""

from __future__ import annotations

from typing import Callable

import numpy as np

from master_thesis.flight.experiment import Outcome
from master_thesis.flight.flight_log import FlightLog
from master_thesis.results.run_report import MAX_CLEARANCE_M, RunDescription, clearance_series
from master_thesis.worlds.floor_plan import Outline, outlines
from simulation_tools.geometry import Pose
from simulation_tools.sdf.parser import load_world
from simulation_tools.uav import load_uav
from simulation_tools.world.world import PhysicsWorld


def clearances(
    description: RunDescription,
    log: FlightLog,
    outcome: Outcome,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> np.ndarray:
    """Return (n, 2): time, and distance in metres from the UAV to the nearest shape but the ground.

    Along the true path, from sending the goal to landing, in the world as its file says.

    Raises:
        SimulationToolsError: the world or the UAV cannot be loaded.
    """
    world = PhysicsWorld(load_world(str(description.scenario.world_path)))
    try:
        model = load_uav(description.model, description.lidar).model
        name = f"{model.name}_measured"
        world.spawn(model, name, Pose.identity())

        def clearance(pose: Pose) -> float:
            return world.clearance(name, pose, MAX_CLEARANCE_M, ignore=outcome.ground)

        return clearance_series(log, outcome, clearance, progress)
    finally:
        world.close()


def floor_plan(description: RunDescription) -> list[Outline]:
    """Return the outlines of the world's solid shapes."""
    return outlines(load_world(str(description.scenario.world_path)))
