"""The map of voxels of a recorded flight: the clouds that its lidar would have seen, along SLAM's path."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

import numpy as np
from matplotlib.figure import Figure

from flights.errors import FlightError
from flights.flight.flight_recording import FlightRecording
from gridslam.evaluation.volume.lidars import VIEWS
from gridslam.evaluation.volume.surface import Surface, read_surface
from gridslam.evaluation.volume.visibility import LidarView, Places
from gridslam.evaluation.volume.volume_error import VolumeError, volume_error
from gridslam.evaluation.volume.volume_picture import volume_error_figure
from gridslam.evaluation.volume.voxels import Voxels, voxels_of
from gridslam.trajectory import Trajectory
from gridslam.volume import FLAT_MISS, CorrectedMap, Pose, VolumeParameters
from gridslam.volume.path_poses import OdometryHistory, PathCorrections
from simulation_tools import geometry
from simulation_tools.sdf.elements import RaySensor
from simulation_tools.sensors.cloud import CloudLidar
from simulation_tools.vehicle.uav import load_uav

RESOLUTION_M, RANGE_M = 0.1, 30.0
"""Of volume.launch. `miss` is that of mapping.launch."""


@dataclass(frozen=True)
class SurfaceRays:
    """A surface as the rays of a simulated lidar."""

    surface: Surface

    def cast(
        self, origins: np.ndarray, directions: np.ndarray, max_range_m: float, ignore_model: str | None
    ) -> np.ndarray:
        """Return the distance (n,) along each ray of directions (n, 3), inf for none."""
        ranges_m = self.surface.ranges_m(np.broadcast_to(origins, directions.shape), directions)
        return np.where(ranges_m <= max_range_m, ranges_m, np.inf).astype(np.float32)


@dataclass(frozen=True)
class JudgedVolume:
    """A map of voxels and its errors. clouds: that are in it."""

    surface: Surface
    voxels: Voxels
    places: Places
    error: VolumeError
    distances_m: np.ndarray
    clouds: int

    def figure(self) -> Figure:
        """Return the printed picture."""
        return volume_error_figure(self.voxels, self.surface, self.error, self.distances_m, self.places)


def map_and_judge(
    recording: FlightRecording, world: Path, lidar: str, path: Trajectory, seed: int
) -> JudgedVolume:
    """Map the clouds of a flight and judge the map.

    The clouds come from the true poses. The map takes them to be where odometry, corrected by SLAM's path,
    says, as `slam_octomap` does after the last loop closure.

    Args:
        recording: of the flight.
        world: SDF file.
        lidar: name; it has several channels.
        path: SLAM's, in `map`.
        seed: of the lidar's noise and of the samples.

    Raises:
        FlightError: the lidar has no cloud.
        SlamError: the map cannot be made or judged.
    """
    rng, surface = np.random.default_rng(seed), read_surface(world)
    sensor = CloudLidar(_cloud_sensor(lidar), rng)
    mount = geometry.Pose(recording.lidar.position_m, recording.lidar.orientation_xyzw)
    corrections = corrections_of(recording, path)
    corrected = CorrectedMap(VolumeParameters(resolution_m=RESOLUTION_M, max_range_m=RANGE_M, miss=FLAT_MISS))
    rays, places, clouds = SurfaceRays(surface), [], 0
    for scan in recording:
        sensor_in_odom, true_place = as_volume(scan.odometry @ mount), scan.truth @ mount
        places.append(as_volume(true_place))
        if not (corrections.cover(scan.t_s) and corrected.asks_for(scan.t_s, sensor_in_odom)):
            continue
        points = sensor.read(rays, true_place).points_m
        corrected.add(scan.t_s, points, sensor_in_odom, corrections.at(scan.t_s))
        clouds += 1
    return judged(corrected, surface, places, lidar, rng, clouds)


def corrections_of(recording: FlightRecording, path: Trajectory) -> PathCorrections:
    """Return where SLAM's path says that odometry's frame was; raises PoseError if it cannot."""
    history = OdometryHistory()
    for scan in recording:
        history.add(scan.t_s, as_volume(scan.odometry))
    return PathCorrections(path.stamps_s, path.poses_in_map, history, path.heights_m)


def judged(
    corrected: CorrectedMap,
    surface: Surface,
    places: Sequence[Pose],
    lidar: str,
    rng: np.random.Generator,
    clouds: int,
) -> JudgedVolume:
    """Judge a map. places: true poses of the lidar; lidar: its name; clouds: that are in the map."""
    voxels = voxels_of(corrected.voxels, Pose.identity(), rng)
    seen_from = Places(
        np.array([each.translation for each in places]), np.array([each.rotation for each in places])
    )
    error, distances_m = volume_error(voxels, surface, rng, seen_from, _view(lidar))
    return JudgedVolume(surface, voxels, seen_from, error, distances_m, clouds)


def _cloud_sensor(lidar: str) -> RaySensor:
    """Return the sensor of a lidar's model that has several channels."""
    for _, sensor in load_uav("iris", lidar).model.sensors(RaySensor):
        if sensor.vertical.samples > 1:
            return sensor
    raise FlightError(f"The lidar {lidar} has one plane of beams, and no cloud.")


def _view(lidar: str) -> LidarView:
    beams = VIEWS[lidar]
    return LidarView(beams.elevation_deg, beams.field_of_view_deg, min(beams.range_max_m, RANGE_M))


def as_volume(pose: geometry.Pose) -> Pose:
    """Return a simulated pose as the map's."""
    return Pose(pose.rotation, np.array(pose.position_m))
