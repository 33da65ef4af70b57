"""Experiments 3 and 4 without ROS: one flight, mapped without and with loop closure, with metrics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np
from matplotlib.figure import Figure

from flights.flight.flight_recording import FlightRecording
from flights.flight.parameters import ClosedLoopParameters
from flights.mapping.mapping_flight import SCENARIOS, MappingScenario, fly_and_record
from flights.mapping.slam_metrics import slam_metrics_of
from flights.mapping.slam_run import SlamRun, replay, true_path, true_walls
from flights.mapping.slam_setup import SlamSetup, read_setup
from flights.worlds.floor_plan import outlines_of_file
from gridslam.evaluation import Walls, map_error, poses_at, trajectory_error
from gridslam.trajectory import Trajectory
from master_thesis.experiments_3_4 import slam_pictures, survey_files


@dataclass(frozen=True)
class MappedFlight:
    """A recorded flight with its truth: the true path and the true walls."""

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

    def metrics(self, run: SlamRun) -> dict:
        """Return the metrics of the map, of the map at half time, and of odometry alone."""
        found, _, _ = slam_metrics_of(run, self.truth, self.walls)
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

    def picture(self, run: SlamRun, title: str) -> Figure:
        """Return the picture of world and maps, at half time and at the end."""
        return slam_pictures.world_and_maps(
            title,
            outlines_of_file(self.scenario.world_path),
            self.scenario.flight_height_m,
            self.truth.poses_in_map[:, :2],
            survey_files.map_views(run),
        )


def medians(several: Sequence[dict]) -> dict:
    """Return each metric's median over the seeds, and the greatest ATE."""
    middle = {key: _median([metrics[key] for metrics in several]) for key in several[0]}
    return {**middle, "ate_rmse_worst_m": max(m["ate_rmse_m"] for m in several), "seeds": len(several)}


def _median(values: Sequence) -> float | None:
    finite = [value for value in values if value is not None and np.isfinite(value)]
    return float(np.median(finite)) if finite else None
