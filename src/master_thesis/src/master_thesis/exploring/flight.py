"""One exploring flight in the closed loop without ROS and without GNSS."""

from __future__ import annotations

import math

import numpy as np

from gridslam.errors import SlamError
from gridslam.inputs.attitude import matrix_of_quaternion
from gridslam.odometry import OdometryEstimate
from gridslam.volume import Pose, VolumeParameters
from inspection_tools.exploration import (
    Exploration,
    ExplorationParameters,
    Explored,
    Explorer,
    ExplorerParameters,
)
from inspection_tools.planning import PathPlanner, PlannerParameters
from master_thesis.errors import FlightError
from master_thesis.exploring.volume_of_flight import VolumeOfFlight
from master_thesis.flight.closed_loop import ClosedLoop
from master_thesis.flight.course import Phase
from simulation_tools.geometry import quaternion_from_rpy
from simulation_tools.sensors.cloud import Cloud, CloudLidar

CLOUD_S = 0.2
"""The map takes a cloud so often."""


class ExploringFlight:
    """Leads a closed loop from view to view, and home.

    Args:
        loop: a flight without GNSS, with a lidar that has clouds, and without a goal.
        planner, explorer, volume: their parameters.
        time_s: of simulation; after that the UAV flies home.

    Raises:
        FlightError: the UAV has no clouds or flies by GNSS.
    """

    def __init__(
        self,
        loop: ClosedLoop,
        planner: PlannerParameters,
        explorer: ExplorerParameters,
        volume: VolumeParameters,
        time_s: float = math.inf,
    ) -> None:
        lidars = [sensor for sensor in loop.simulation.payload if isinstance(sensor.device, CloudLidar)]
        if not lidars or loop.own_odometry is None:
            raise FlightError("Exploration needs a lidar with clouds and a flight without GNSS.")
        self._loop, self._own, self._lidar = loop, loop.own_odometry, lidars[0]
        mount = self._lidar.mount.pose
        self._lidar_in_base = Pose(mount.rotation, np.array(mount.position_m))
        self.volume = VolumeOfFlight(PathPlanner(planner), volume)
        self.exploration = Exploration(
            self.volume.planner, Explorer(explorer), ExplorationParameters(time_max=time_s)
        )
        self._clouds: dict[int, np.ndarray] = {}
        self._seen, self._cloud_s = 0, -math.inf
        self._setpoint_m: np.ndarray | None = None

    def run(self) -> Explored:
        """Fly until the UAV has landed, or the run has failed."""
        loop = self._loop
        while not loop.is_over:
            output = loop.step()
            if self._lidar in output.payload:
                cloud = self._lidar.shared()
                assert isinstance(cloud, Cloud)
                self._clouds[output.time_us] = cloud.points_m
            for estimate in self._own.estimates[self._seen :]:
                self._map(estimate)
            self._seen = len(self._own.estimates)
            if self._own.estimates:
                self._lead(self._own.estimates[-1], loop.monitor.course.phase is Phase.FLYING)
        return self.exploration.told

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
            self.volume.add(estimate.stamp_s, points, base @ self._lidar_in_base)
        except SlamError:
            return  # a cloud without a point

    def _lead(self, estimate: OdometryEstimate, is_flying: bool) -> None:
        here_m, now_s = np.array(estimate.position_xyz), self._loop.time_s
        if is_flying and not self.exploration.has_begun:
            self.exploration.begin(now_s, here_m)
        if self.exploration.follow(now_s, here_m):
            self.volume.tell_planner()
            self.exploration.look(now_s, here_m)
        setpoint_m = self.exploration.setpoint_m
        if is_flying and setpoint_m is not None and setpoint_m is not self._setpoint_m:
            self._setpoint_m = setpoint_m
            self._loop.position_controller.set_setpoint(setpoint_m.tolist())
        if self.exploration.is_home:
            self._loop.monitor.on_goal_reached(True)
        elif self.exploration.must_land:
            self._loop.monitor.land_here(f"The UAV did not come home: {self.exploration.told.reason}")
