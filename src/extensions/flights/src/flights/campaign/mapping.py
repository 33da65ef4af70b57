"""Flies a mission with SLAM beside it, and measures how true map and path are."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from flights.campaign.axes import CEPA_PREFIX, SLAM_PREFIX, parameters_in, scenario_name
from flights.campaign.campaign import Case
from flights.campaign.flying import begin, flight_of, is_over
from flights.flight.closed_loop import ClosedLoop
from flights.flight.flight_recording import LidarGeometry
from flights.flight.parameters import ClosedLoopParameters
from flights.mapping.mapping_flight import SCENARIOS, parameters_of
from flights.mapping.slam_metrics import slam_metrics_of
from flights.mapping.slam_run import SlamParticipant, SlamRun, planar, true_walls
from flights.mapping.slam_setup import SlamSetup, read_setup
from gridslam.evaluation import Walls, poses_at, trajectory_error
from gridslam.trajectory import Trajectory
from simulation_tools.simulation import SimulationParameters

MAP_METRICS = (
    "ate_rmse_m",
    "ate_max_m",
    "ate_rotation_rmse_deg",
    "ate_online_rmse_m",
    "odometry_ate_rmse_m",
    "end_error_m",
    "map_error_mean_m",
    "map_error_p95_m",
    "wall_seen_share",
    "wall_turned_max_rad",
    "closures",
)
"""How true a map is; see `gridslam.evaluation`."""


def fly_and_map(case: Case, simulation: SimulationParameters) -> dict[str, Any]:
    """Fly a trial's mission with SLAM beside it; return its columns, without `MAP_METRICS` if it failed.

    Raises:
        FlightError: the UAV never hovered over the start.
        SlamError, ScenarioError: there is nothing to judge.
    """
    scenario = SCENARIOS[scenario_name(case.settings["world"])]
    options = parameters_in(case.settings, SLAM_PREFIX)
    closing, levelling = options.pop("loop_closure", True), options.pop("levelling", True)
    setup = read_setup(scenario.world)
    setup = SlamSetup(replace(setup.parameters, **options), setup.loop_closure)
    with ClosedLoop(_parameters(case, simulation)) as loop:
        session = setup.session(case.noise_seed, closing)
        assert loop.simulation.lidar is not None
        slam = SlamParticipant(session, LidarGeometry.of(loop.simulation.lidar), levelling=levelling)
        loop.listeners.append(slam)
        begin(loop)
        loop.run(until=is_over)
        flight = flight_of(loop)
        truth, odometry = planar(loop.log.truth), planar(loop.log.odometry)
    columns = {"mapped": flight.end == "goal", **flight.columns()}
    if not columns["mapped"]:
        return columns
    walls = true_walls(simulation.world, scenario.flight_height_m, scenario.start_xyz_yaw[:2])
    return {**columns, **_judged(slam.run(), truth, odometry, walls)}


def _parameters(case: Case, simulation: SimulationParameters) -> ClosedLoopParameters:
    settings = case.settings
    base = parameters_of(scenario_name(settings["world"]), settings["lidar"], case.noise_seed)
    return replace(
        base,
        simulation=replace(simulation, spawn_pose=base.simulation.spawn_pose),
        cepa=replace(base.cepa, **parameters_in(settings, CEPA_PREFIX)),
        position_controller=replace(base.position_controller, max_speed=settings["speed_m_s"]),
        duration_s=settings["duration_s"] or base.duration_s,
    )


def _judged(run: SlamRun, truth: Trajectory, odometry: Trajectory, walls: Walls) -> dict[str, Any]:
    judged, _, _ = slam_metrics_of(run, truth, walls)
    stamps = run.final.stamps_s
    drift = trajectory_error(Trajectory(stamps, poses_at(odometry, stamps)), truth)
    judged["odometry_ate_rmse_m"] = drift.ate_rmse_m
    return {name: judged[name] for name in MAP_METRICS}
