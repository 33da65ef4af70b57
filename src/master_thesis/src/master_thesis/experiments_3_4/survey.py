"""Measures the map of a flight: from its log and SLAM's output to files and metrics."""

from __future__ import annotations

from typing import Callable

from flights.flight.course import Outcome
from flights.flight.description import RunDescription
from flights.flight.flight_log import FlightLog
from flights.mapping.slam_run import SlamRun, planar, true_walls
from flights.results.metrics import flight_interval_s
from flights.results.run_folder import RunFolder
from flights.worlds.floor_plan import outlines_of_file
from flights.worlds.scenario import FLIGHT_HEIGHT_M
from gridslam.trajectory import Trajectory
from master_thesis.experiments_3_4.survey_files import Surveyed, write_survey


def survey(
    folder: RunFolder,
    description: RunDescription,
    log: FlightLog,
    outcome: Outcome,
    slam: Callable[[Trajectory, float], SlamRun],
) -> dict:
    """Write maps, trajectories and pictures of a flight; return its metrics.

    slam: returns SLAM's output, given the odometry of the whole flight and the time at half of it.

    Raises:
        SlamError: there is no map, or it is empty.
        SimulationToolsError, ScenarioError: the world cannot be read, or has no walls.
        ResultsError: a file cannot be written.
    """
    scenario = description.scenario
    odometry = planar(log.odometry)
    start_s, end_s = flight_interval_s(log, outcome)
    height_m = FLIGHT_HEIGHT_M
    return write_survey(
        folder,
        Surveyed(
            title=f"{scenario.name}, {description.lidar}, seed {description.seed}",
            run=slam(odometry, (start_s + end_s) / 2),
            truth=planar(log.truth),
            odometry=odometry,
            walls=true_walls(scenario.world_path, height_m, scenario.start_xyz_yaw[:2]),
            outlines=outlines_of_file(scenario.world_path),
            height_m=height_m,
        ),
    )
