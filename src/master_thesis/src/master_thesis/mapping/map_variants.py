"""Experiments 3 and 4 without ROS: one flight, mapped without and with loop closure, and judged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np

from gridslam.evaluation import Walls, map_error, poses_at, trajectory_error
from gridslam.trajectory import Trajectory
from master_thesis.flight.closed_loop import ClosedLoopParameters
from master_thesis.flight.flight_recording import FlightRecording
from master_thesis.mapping import slam_figures, slam_files
from master_thesis.mapping.mapping_flight import SCENARIOS, MappingScenario, fly_and_record
from master_thesis.mapping.slam_report import judge
from master_thesis.mapping.slam_run import SlamRun, replay, true_path, true_walls
from master_thesis.mapping.slam_setup import SlamSetup, read_setup
from master_thesis.worlds import floor_plan
from simulation_tools.sdf.parser import load_world


@dataclass(frozen=True)
class MappedFlight:
    """A recorded flight with what its maps are judged by: the true path and the true walls."""

    scenario: MappingScenario
    setup: SlamSetup
    recording: FlightRecording
    truth: Trajectory
    walls: Walls

    @classmethod
    def fly(cls, name: str, lidar: str, seed: int, parameters: ClosedLoopParameters) -> MappedFlight:
        """Fly one of the mapping scenarios.

        Raises:
            FlightError: the mission was not flown to its end, or something was touched.
        """
        scenario = SCENARIOS[name]
        recording = fly_and_record(f"{name}, {lidar}, seed {seed}", parameters)
        walls = true_walls(scenario.world_path, scenario.flight_height_m, scenario.start_xyz_yaw[:2])
        truth = true_path(recording.times_s, recording.truth)
        return cls(scenario, read_setup(scenario.world), recording, truth, walls)

    def map(self, seed: int, loop_closure: bool) -> SlamRun:
        """Run SLAM on the recording."""
        return replay(self.recording, self.setup.session(seed, loop_closure=loop_closure))

    def figures(self, run: SlamRun) -> dict:
        """Return the figures of merit of a map; of the one at half time, and of odometry alone, besides."""
        found, _, _ = judge(run, self.truth, self.walls)
        cpu_ms = found.pop("cpu_ms_per_scan")
        half = map_error(run.half_way, self.walls)
        return {
            **found,
            "cpu_ms": cpu_ms["mean"] if cpu_ms else None,
            "half_way_error_p95_m": half.p95_m,
            "half_way_error_max_m": half.max_m,
            "odometry_ate_rmse_m": self._odometry_ate(run),
        }

    def _odometry_ate(self, run: SlamRun) -> float:
        stamps = run.final.stamps_s
        odometry = true_path(self.recording.times_s, self.recording.odometry)
        return trajectory_error(Trajectory(stamps, poses_at(odometry, stamps)), self.truth).ate_rmse_m

    def figure(self, run: SlamRun, title: str):
        """Return the picture of world and maps, at half time and at the end."""
        return slam_figures.world_and_maps(
            title,
            floor_plan.outlines(load_world(str(self.scenario.world_path))),
            self.scenario.flight_height_m,
            self.truth.poses_in_map[:, :2],
            slam_files.map_views(run),
        )


def medians(several: Sequence[dict]) -> dict:
    """Return each figure's median over the seeds, and the greatest ATE."""
    middle = {key: _median([figures[key] for figures in several]) for key in several[0]}
    return {**middle, "ate_rmse_worst_m": max(f["ate_rmse_m"] for f in several), "seeds": len(several)}


def _median(values: Sequence) -> float | None:
    finite = [value for value in values if value is not None and np.isfinite(value)]
    return float(np.median(finite)) if finite else None
