"""Puts the clouds of a flight without ROS and without GNSS into its map, by the odometry's poses."""

from __future__ import annotations

import math

import numpy as np

from flights.errors import FlightError
from flights.exploring.drift import Drift
from flights.exploring.volume_of_flight import VolumeOfFlight
from flights.flight.closed_loop import ClosedLoop
from gridslam.errors import SlamError
from gridslam.inputs.attitude import matrix_of_quaternion
from gridslam.odometry import OdometryEstimate
from gridslam.volume import Pose, RangePoints
from simulation_tools.geometry import quaternion_from_rpy
from simulation_tools.sensors.cloud import Cloud, CloudLidar
from simulation_tools.sensors.range_finder import RangeFinder
from simulation_tools.simulation import StepOutput

CLOUD_S = 0.2
"""The map takes a cloud so often."""


class FlownClouds:
    """Follows a closed loop step by step.

    drift: of SLAM's poses; None: the map is in the frame of odometry. Set it before the flight.

    Raises:
        FlightError: the UAV has no clouds or flies by GNSS.
    """

    def __init__(self, loop: ClosedLoop, volume: VolumeOfFlight, name: str) -> None:
        """name: of what is flown, at the beginning of a sentence."""
        lidars = [sensor for sensor in loop.simulation.payload if isinstance(sensor.device, CloudLidar)]
        if not lidars or loop.own_odometry is None:
            raise FlightError(f"{name} needs a lidar with clouds and a flight without GNSS.")
        self._own, self._lidar, self._volume = loop.own_odometry, lidars[0], volume
        in_base = {
            sensor.name: Pose(sensor.mount.pose.rotation, np.array(sensor.mount.pose.position_m))
            for sensor in loop.simulation.payload
        }
        self._lidar_in_base = in_base[self._lidar.name]
        self._in_lidar = {name: self._lidar_in_base.inverse() @ pose for name, pose in in_base.items()}
        # As for CEPA, range finders count in pairs: one that looks up and one that looks down
        finders = [each for each in loop.simulation.payload if isinstance(each.device, RangeFinder)]
        self._finders = finders if len(finders) > 1 else []
        self._ranges = RangePoints()
        self._clouds: dict[int, np.ndarray] = {}
        self._seen, self._cloud_s = 0, -math.inf
        self.drift: Drift | None = None

    @property
    def newest(self) -> OdometryEstimate | None:
        """The newest pose; None before the first."""
        return self._own.estimates[-1] if self._own.estimates else None

    def take(self, output: StepOutput) -> None:
        """Take what a step of the simulation gave."""
        for sensor in output.payload:
            if sensor in self._finders and isinstance(sensor.device, RangeFinder):
                limits = sensor.device.range_min, sensor.device.range_max
                reading = sensor.shared()
                assert isinstance(reading, float)
                self._ranges.take(sensor.name, 1e-6 * output.time_us, reading, *limits)
        if self._lidar in output.payload:
            cloud = self._lidar.shared()
            assert isinstance(cloud, Cloud)
            stamp_s = 1e-6 * output.time_us
            self._clouds[output.time_us] = self._ranges.added_to(cloud.points_m, stamp_s, self._in_lidar.get)
        for estimate in self._own.estimates[self._seen :]:
            self._map(estimate)
        self._seen = len(self._own.estimates)

    def _map(self, estimate: OdometryEstimate) -> None:
        stamp_us = round(1e6 * estimate.stamp_s)
        points = self._clouds.pop(stamp_us, None)
        self._clouds = {key: cloud for key, cloud in self._clouds.items() if key > stamp_us}
        is_placed = estimate.share > 0.0 and not estimate.remark  # the first clouds begin the odometry's map
        if points is None or not is_placed or estimate.stamp_s < self._cloud_s + CLOUD_S:
            return
        self._cloud_s = estimate.stamp_s
        rotation = matrix_of_quaternion(quaternion_from_rpy(*estimate.roll_pitch_yaw))
        base = Pose(rotation, np.array(estimate.position_xyz))
        try:
            odom_in_map = None if self.drift is None else self.drift.odom_in_map(estimate.stamp_s)
            self._volume.add(estimate.stamp_s, points, base @ self._lidar_in_base, odom_in_map)
        except SlamError:
            return  # a cloud without a point
