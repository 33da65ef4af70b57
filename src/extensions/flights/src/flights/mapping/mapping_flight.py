"""Experiments 3 and 4 without ROS: the scenarios, and the recorded flight for SLAM (thesis, 8.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from flights.errors import FlightError
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase
from flights.flight.flight_recording import FlightRecorder, FlightRecording
from flights.flight.parameters import CEPA, ClosedLoopParameters
from flights.worlds.scenario import FLIGHT_HEIGHT_M, choose
from inspection_tools import PositionControllerParameters, Waypoint, read_mission
from simulation_tools.geometry import Pose
from simulation_tools.sensors.odometry import OdometryParameters
from simulation_tools.simulation import SimulationParameters

R_UB_M = 0.9
"""CEPA's outer radius indoors. With the default of 1.2 m the slow UAV would stop before passages of 2 m."""

PACKAGE = Path(__file__).resolve().parents[3]


@dataclass(frozen=True)
class MappingScenario:
    """A world to map, the UAV's start, its mission, and the flight's duration and speed."""

    world: str
    mission: str
    start_xyz_yaw: tuple[float, float, float, float]
    speed_m_s: float
    duration_s: float = math.inf

    @property
    def world_path(self) -> Path:
        """The SDF file."""
        return PACKAGE / "worlds" / f"{self.world}.world"

    @cached_property
    def waypoints(self) -> tuple[Waypoint, ...]:
        """The mission's waypoints. The file is read once."""
        return read_mission(PACKAGE / "config" / "missions" / f"{self.mission}.yaml")

    @property
    def flight_height_m(self) -> float:
        """Height of the flight over the floor. The map shows the world at this height."""
        return FLIGHT_HEIGHT_M


SCENARIOS = {
    "room": MappingScenario("room", "room", (-5.5, -0.5, 0.0, 0.0), speed_m_s=0.6, duration_s=240.0),
    "hold": MappingScenario("hold", "hold", (0.0, -7.0, 0.0, 0.0), speed_m_s=1.0),
    "hold_middle": MappingScenario("hold", "hold_middle", (-8.0, 0.0, 0.0, 0.0), speed_m_s=1.0),
}
"""Experiment 3, Experiment 4, and the flight down the middle that the thesis advises for the TiM (9.1.2)."""


def parameters_of(
    name: str,
    lidar: str,
    seed: int,
    odometry: OdometryParameters | None = None,
    lidar_range_max_m: float = 0.0,
) -> ClosedLoopParameters:
    """Return the closed loop of one of the scenarios. odometry: its drift; default: the experiments'.

    Raises:
        ScenarioError: there is no such scenario.
    """
    choose("scenario", name, tuple(SCENARIOS))
    scenario = SCENARIOS[name]
    x, y, z, yaw = scenario.start_xyz_yaw
    simulation = SimulationParameters(
        world=str(scenario.world_path),
        lidar=lidar,
        spawn_pose=Pose.from_xyz_rpy(x, y, z, 0.0, 0.0, yaw),
        seed=seed,
        odometry=odometry or OdometryParameters(),
        lidar_range_max_m=lidar_range_max_m,
    )
    return ClosedLoopParameters(
        simulation,
        mission=scenario.waypoints,
        cepa=replace(CEPA, r_ub=R_UB_M),
        duration_s=scenario.duration_s,
        position_controller=replace(PositionControllerParameters(), max_speed=scenario.speed_m_s),
    )


def fly_and_record(name: str, parameters: ClosedLoopParameters) -> FlightRecording:
    """Fly until the mission is over. Return SLAM's input from the start on.

    Raises:
        FlightError: the mission was not flown to its end, or something was touched.
    """
    with ClosedLoop(parameters) as loop:
        recorder = FlightRecorder(name, loop.lidar)
        loop.listeners.append(recorder)
        outcome = loop.run_to(Phase.HOVERING)
    if not outcome.reached_goal or outcome.collision:
        raise FlightError(f"The flight {name} failed: {outcome.failure or 'the mission was not flown.'}")
    return recorder.recording()
