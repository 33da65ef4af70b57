"""The part of the chain between a scan and a velocity, from the classes of its nodes."""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np

from cepa import LaserScan2D, LidarAttitude, Motion, Ranging, levelled
from cepa.algorithm import Algorithm
from cepa.decision import Decision
from cepa.motion import Cloud
from inspection_tools import (
    LidarMedianFilter,
    LidarPadding,
    MedianFilterParameters,
    PaddingParameters,
    ScanGeometry,
    YawRegulator,
    YawRegulatorParameters,
)
from simulation_tools.geometry import Pose, Vector3, rotate
from simulation_tools.sensors.cloud import Cloud as LidarTurn
from simulation_tools.sensors.cloud import CloudLidar
from simulation_tools.sensors.lidar import Lidar
from simulation_tools.sensors.odometry import OdometrySample
from simulation_tools.sensors.range_finder import RangeFinder
from simulation_tools.simulation import StepOutput


class Answer(NamedTuple):
    """What is flown after a scan. velocity_m_s: ahead, left, up. computation_ms: CPU time of the decision."""

    velocity_m_s: Vector3
    yaw_rate_rad_s: float
    decision: Decision
    computation_ms: float


class SteeringChain:
    """Median filter, padding, collision avoidance and yaw regulator, in the order of the nodes.

    uses_range_finders: the algorithm climbs and sinks into what range finders have seen.
    """

    def __init__(
        self,
        lidar: Lidar,
        algorithm: Algorithm,
        median_filter: MedianFilterParameters,
        padding: PaddingParameters,
        yaw_regulator: YawRegulatorParameters,
        uses_range_finders: bool,
    ) -> None:
        self._lidar = lidar
        self._limits = lidar.range_min, lidar.range_max
        self._geometry = ScanGeometry(lidar.beams, lidar.angle_min, lidar.angle_increment)
        self._algorithm = algorithm
        self._median_filter = LidarMedianFilter(median_filter)
        self._padding = LidarPadding(padding)
        self._yaw_regulator = YawRegulator(yaw_regulator)
        self._uses_range_finders = uses_range_finders
        self.newest_scan: LaserScan2D | None = None  # the algorithm's input: filtered and padded

    @property
    def commit_s(self) -> float:
        """How long the newest answer is safe to fly."""
        return self._algorithm.commit_s

    def answer(
        self, output: StepOutput, v_ref_m_s: Vector3, odometry: OdometrySample, odometry_age_s: float
    ) -> Answer:
        """Answer the scan of a time step, which must have one."""
        assert output.scan is not None
        cloud = cloud_of(output) if self._algorithm.wants_cloud else None
        if self._uses_range_finders:
            self._algorithm.take_ranges(rangings_of(output, self._lidar.pose_in_body))
        self.newest_scan = scan = self._prepared(output.scan)
        motion = self._motion(1e-6 * output.time_us, v_ref_m_s[2], odometry, odometry_age_s)
        started = time.thread_time()  # CPU time of this thread, so that other load does not count
        if self._algorithm.parameters.levelling:
            scan = self._levelled(scan, odometry)
        own_velocity = odometry.linear_velocity_m_s[:2]
        decision = self._algorithm.steer(scan, v_ref_m_s[:2], own_velocity, motion, cloud)
        computation_ms = 1e3 * (time.thread_time() - started)
        climb = v_ref_m_s[2] if decision.climb_m_s is None else decision.climb_m_s
        yaw_rate = self._yaw_regulator.update(decision.velocity_xy, v_ref_m_s[:2])
        return Answer((*decision.velocity_xy, climb), yaw_rate, decision, computation_ms)

    def _prepared(self, ranges: np.ndarray) -> LaserScan2D:
        filtered = self._median_filter.filter(ranges, self._geometry, *self._limits)
        padded = self._padding.pad(filtered, self._geometry, *self._limits)
        angles = padded.geometry.angle_min_rad, padded.geometry.angle_increment_rad
        return LaserScan2D(padded.ranges, *angles, *self._limits, seen=padded.seen)

    def _motion(self, t_s: float, climb_ref_m_s: float, odometry: OdometrySample, age_s: float) -> Motion:
        lidar = odometry.pose @ self._lidar.pose_in_body
        velocity = rotate(odometry.pose.orientation_xyzw, odometry.linear_velocity_m_s)
        return Motion(t_s, lidar.position_m, lidar.orientation_xyzw, velocity, climb_ref_m_s, age_s)

    def _levelled(self, scan: LaserScan2D, odometry: OdometrySample) -> LaserScan2D:
        body, mount = odometry.pose, self._lidar.pose_in_body
        attitude = LidarAttitude.of_mounted(
            body.position_m[2], body.orientation_xyzw, mount.position_m, mount.orientation_xyzw
        )
        speed_m_s = math.hypot(*odometry.linear_velocity_m_s[:2])
        return levelled(scan, attitude, self._algorithm.parameters, speed_m_s)


def cloud_of(output: StepOutput) -> Cloud | None:
    """Measure with the UAV's three-dimensional lidar, which is due when its scan is; None if it has none."""
    for sensor in output.payload:
        if isinstance(sensor.device, CloudLidar):
            lidar = sensor.device.sensor
            turn = sensor.read()
            assert isinstance(turn, LidarTurn)
            up, around = lidar.vertical, lidar.horizontal
            return Cloud(
                turn.points_m,
                (up.min_angle_rad, up.max_angle_rad),
                lidar.range_min_m,
                lidar.range_max_m,
                (around.min_angle_rad, around.max_angle_rad),
            )
    return None


def rangings_of(output: StepOutput, lidar_in_body: Pose) -> list[Ranging]:
    """Measure with the UAV's range finders that are due. They look along the x axes of their own frames."""
    rangings = []
    for sensor in output.payload:
        if isinstance(sensor.device, RangeFinder):
            in_lidar = lidar_in_body.inverse() @ sensor.mount.pose
            range_m = sensor.read()
            assert isinstance(range_m, float)
            limits = sensor.device.range_min, sensor.device.range_max
            direction: np.ndarray = in_lidar.rotation[:, 0]
            rangings.append(Ranging(in_lidar.position_m, tuple(direction.tolist()), range_m, *limits))
    return rangings
