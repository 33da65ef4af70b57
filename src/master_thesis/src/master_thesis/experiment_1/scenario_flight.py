"""Experiment 1 without ROS: one flight of a scenario, and its metrics (thesis, table 8.1)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from flights.errors import FlightError
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase
from flights.flight.description import RunDescription
from flights.flight.parameters import CEPA, ClosedLoopParameters
from flights.results.clearance import clearances_of_flight, least
from flights.results.metrics import flight_interval_s, flight_metrics
from flights.worlds.experiment_1 import GOAL_X_M
from flights.worlds.scenario import FLIGHT_HEIGHT_M, WORLDS, Scenario
from simulation_tools.simulation import SimulationParameters


@dataclass(frozen=True)
class ScenarioFlight:
    """The result of a flight.

    metrics: arrival, computation time, length of path and clearance by name. path: (n, 4) of time in s and
    true x, y, z in m, from sending the goal to landing. emergencies_xy: (k, 2) places where the emergency
    avoidance answered.
    """

    metrics: dict
    path: np.ndarray
    emergencies_xy: np.ndarray


def scenario_parameters(
    name: str,
    algorithm: str = "improved",
    seed: int = 1,
    goal_x_m: float = GOAL_X_M,
    k_previous: float = 0.0,
) -> ClosedLoopParameters:
    """Return the closed loop of one of Experiment 1's scenarios (UST at 40 Hz, 2 m/s).

    k_previous: CEPA's, for `improved`; 0: the thesis.
    """
    simulation = SimulationParameters(world=str(WORLDS / f"{name}.world"), seed=seed)
    goal_xyz_m, cepa = (goal_x_m, 0.0, FLIGHT_HEIGHT_M), replace(CEPA, k_previous=k_previous)
    return ClosedLoopParameters(simulation, goal_xyz_m=goal_xyz_m, algorithm=algorithm, cepa=cepa)


def fly_scenario(parameters: ClosedLoopParameters) -> ScenarioFlight:
    """Fly to the goal and hover. The computation time is CEPA's CPU time, so other load does not count."""
    with ClosedLoop(parameters) as loop:
        outcome = loop.run_to(Phase.LANDING)
        log = loop.log
    simulation, goal = parameters.simulation, parameters.goal_xyz_m
    if goal is None or simulation.lidar is None:
        raise FlightError("A flight of Experiment 1 needs a goal and a lidar.")
    world = Path(simulation.world)
    flown = Scenario(world.stem, world, goal_xyz_m=goal)
    description = RunDescription(
        "experiment_1", flown, parameters.algorithm, simulation.lidar, simulation.seed
    )
    found = flight_metrics(log, outcome, goal)
    metrics = {
        "reached_goal": outcome.reached_goal,
        "collision": outcome.collision,
        "computation_ms": found["cepa_computation_ms"]["mean"],
        "computation_p99_ms": found["cepa_computation_ms"]["p99"],
        "directions": found["cepa_directions_tested"]["mean"],
        "flight_time_s": found["flight_time_s"],
        "path_length_m": found["path_length_m"],
        "clearance_m": least(clearances_of_flight(description, log, outcome)),
        "emergencies": found["emergencies"],
    }
    start_s, _ = flight_interval_s(log, outcome)
    path = log.between(start_s, outcome.times_s.get(Phase.LANDING, np.inf))[:, :4]
    times_s = [row[0] for row in log.decisions if row[4] and row[0] >= start_s]
    places = np.column_stack([np.interp(times_s, path[:, 0], path[:, axis]) for axis in (1, 2)])
    return ScenarioFlight(metrics, path, places)
