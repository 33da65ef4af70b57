"""Experiment 4 with a planar lidar that nods at each stop, and the map of voxels of its sweeps."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np

from flights.errors import FlightError
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Outcome
from flights.flight.flight_recording import FlightRecorder, FlightRecording
from flights.flight.lidar.nodding import SweptScan
from flights.flight.parameters import ClosedLoopParameters
from flights.mapping.mapping_flight import PACKAGE, SCENARIOS
from flights.mapping.slam_run import replay, true_path
from flights.mapping.slam_setup import read_setup
from gridslam.errors import ScanError
from gridslam.evaluation import trajectory_error
from gridslam.evaluation.volume.surface import read_surface
from gridslam.trajectory import Trajectory
from gridslam.volume import CorrectedMap, PlacedCloud, ScanGathering, VolumeParameters, points_of_scan
from inspection_tools import MedianFilterParameters, read_mission
from master_thesis.experiments_3_4.volume.flight import (
    RANGE_M,
    RESOLUTION_M,
    JudgedVolume,
    as_volume,
    corrections_of,
    judged,
)
from simulation_tools import geometry
from simulation_tools.vehicle.nod import Nod

NOD = Nod(amplitude_rad=0.7, period_s=4.0, sweeps=2)
"""Of experiment_4.launch."""
MISSION = PACKAGE / "config" / "missions" / "hold_nod.yaml"
WORLD = "hold"


def with_nod(parameters: ClosedLoopParameters) -> ClosedLoopParameters:
    """Return the flight through the hold with stops at which the lidar nods.

    CEPA is `dynamic`, with single beams. `improved` pushes a UAV that hovers among unseen sectors away from
    its stop, and each push ends the nod.
    """
    return replace(
        parameters,
        mission=read_mission(MISSION),
        nod=NOD,
        algorithm="dynamic",
        median_filter=MedianFilterParameters(window=1),
    )


@dataclass(frozen=True)
class NoddingFlight:
    """A flight to map.

    recording: of the level scans. swept: all scans, with the lidar's poses. odometry: (n, 8) of time in s,
    position and quaternion xyzw, at all of these.
    """

    outcome: Outcome
    recording: FlightRecording
    swept: Sequence[SweptScan]
    odometry: np.ndarray

    @classmethod
    def fly(cls, name: str, parameters: ClosedLoopParameters) -> NoddingFlight:
        """Fly to the end; raises FlightError if the mission was not flown, or something was touched."""
        with ClosedLoop(parameters) as loop:
            assert loop.nodding is not None  # see `with_nod`
            recorder = FlightRecorder(name, loop.lidar)
            loop.listeners.append(recorder)
            outcome = loop.run()
            swept, odometry = loop.nodding.swept, np.array(loop.log.odometry.rows)
        if not outcome.reached_goal or outcome.collision:
            raise FlightError(f"The flight {name} failed: {outcome.failure or 'the mission was not flown.'}")
        return cls(outcome, recorder.recording(), swept, odometry)

    def map_and_judge(self, lidar: str, seed: int) -> tuple[JudgedVolume, float]:
        """Return the map of the sweeps along SLAM's path, and the path's ATE in m.

        lidar: its name. seed: of SLAM's particles and of the judge's samples.

        Raises:
            SlamError: the map cannot be made or judged.
        """
        recording, rng = self.recording, np.random.default_rng(seed)
        path = replay(recording, read_setup(WORLD).session(seed, loop_closure=True)).final
        corrected, clouds = map_swept(recording, self.swept, self.odometry, path)
        surface = read_surface(SCENARIOS[WORLD].world_path)
        places = [as_volume(scan.truth @ scan.lidar_in_base) for scan in self.swept]
        truth = true_path(recording.times_s, recording.truth)
        return judged(corrected, surface, places, lidar, rng, clouds), trajectory_error(
            path, truth
        ).ate_rmse_m


def map_swept(
    recording: FlightRecording, swept: Sequence[SweptScan], odometry: np.ndarray, path: Trajectory
) -> tuple[CorrectedMap, int]:
    """Map scans of a lidar that nods, as `slam_octomap` does after the last closure; return map and clouds.

    odometry: (n, 8) as in `NoddingFlight`; a scan without it is left out. path: SLAM's, in `map`.
    """
    told = {round(1e6 * row[0]): geometry.Pose(tuple(row[1:4]), tuple(row[4:8])) for row in odometry.tolist()}
    lidar, corrections = recording.lidar, corrections_of(recording, path)
    limits_m = lidar.range_min_m, lidar.range_max_m
    range_m = min(RANGE_M, lidar.range_max_m)
    corrected = CorrectedMap(VolumeParameters(resolution_m=RESOLUTION_M, max_range_m=range_m))
    gathering, clouds = ScanGathering(RESOLUTION_M), 0
    for scan in swept:
        base_in_odom = told.get(round(1e6 * scan.t_s))
        if base_in_odom is None or not corrections.cover(scan.t_s):
            continue
        angles_rad = lidar.angle_min_rad, lidar.angle_increment_rad
        try:
            points = points_of_scan(scan.ranges, angles_rad, limits_m, range_m)
        except ScanError:
            continue  # without a beam that tells anything
        in_odom = as_volume(base_in_odom @ scan.lidar_in_base)
        cloud = gathering.add(PlacedCloud(scan.t_s, points, in_odom, corrections.at(scan.t_s)))
        clouds += _add(corrected, cloud)
    return corrected, clouds + _add(corrected, gathering.take())


def _add(corrected: CorrectedMap, cloud: PlacedCloud | None) -> int:
    if cloud is None:
        return 0
    corrected.add(*cloud)
    return 1
