"""From the messages of lidar, IMU and range finder to the lidar odometry's intake."""

from __future__ import annotations

import math
from typing import Any, Callable

import numpy as np
from genpy import Time
from sensor_msgs.msg import Imu, LaserScan, PointCloud2, Range

from gridslam import ScanError
from gridslam.cloud_odometry import CloudOdometry, SensedCloud
from gridslam.odometry import LidarOdometry, OdometryEstimate
from gridslam.odometry.inertial import InertialReading
from gridslam.odometry.intake import Answer, OdometryIntake, SensedRange, SensedScan
from gridslam_ros.frames.odometry_frames import Pose, sweep
from input_checks.point_times import SweptClouds
from input_checks_ros.lidar_readings import LidarReadings, times_of
from node_tools.clouds import CloudError
from node_tools.conversions import time_of, xyz, xyzw
from stamp_pairing.clock_steps import SharedSteadyTime

LONGEST_GAP_S = 0.5
"""After a longer time without any message of the three sensors the clock was set. The odometry would leap if
it took that for time in which the UAV flew on."""


class OdometryFeed:
    """Converts the messages, and hands on what `OdometryIntake` answers.

    A clock that is set ahead is no time in which the UAV flew on. So the odometry has a steady time, and each
    answer the exact stamp of its scan or cloud.

    Args:
        odometry, mount, imu_lag_s, say: as for `OdometryIntake`.
        publish: is called with each estimate and the exact stamp of its scan or cloud.
    """

    def __init__(
        self,
        odometry: LidarOdometry | CloudOdometry,
        mount: Callable[[str], Pose],
        imu_lag_s: float,
        publish: Callable[[Time, OdometryEstimate], None],
        say: Callable[[str], None],
    ) -> None:
        self._intake: OdometryIntake[Any] = OdometryIntake(odometry, mount, say, imu_lag_s)
        self._give, self._say = publish, say
        self._readings, self._swept = LidarReadings(say), SweptClouds(say)
        self._motion = 0.0, 0.0  # speed, m/s, and rate of turning, rad/s
        self._time = SharedSteadyTime(LONGEST_GAP_S)
        self._imu_began_s = math.inf

    def on_imu(self, message: Imu) -> None:
        """Take the attitude, the rates and, if it is measured, the specific force.

        Of the first instant the force does not count.
        """
        stamp_s = self._time.at(message.header.stamp.to_sec())
        self._imu_began_s = min(stamp_s, self._imu_began_s)
        # A simulator in lockstep repeats the first instant, at first before MAVROS knows the force
        has_force = message.linear_acceleration_covariance[0] >= 0.0 and stamp_s > self._imu_began_s
        try:
            reading = InertialReading(
                stamp_s,
                xyzw(message.orientation),
                xyz(message.angular_velocity),
                xyz(message.linear_acceleration) if has_force else None,
            )
        except ScanError as error:
            self._say(str(error))
            return
        self._publish(self._intake.on_imu(reading))

    def on_range(self, message: Range) -> None:
        """Take a range."""
        limits = message.min_range, message.max_range
        sensed = SensedRange(message.range, limits, message.header.frame_id)
        self._publish(self._intake.on_range(self._time.at(message.header.stamp.to_sec()), sensed))

    def on_scan(self, message: LaserScan) -> None:
        """Take a scan, for `LidarOdometry`."""
        stamp, message = message.header.stamp, self._readings.scan(message)
        scan = SensedScan(
            stamp.to_nsec(),
            self._time.at(stamp.to_sec()),
            np.asarray(message.ranges, float),
            (message.angle_min, message.angle_increment),
            (message.range_min, message.range_max),
            message.header.frame_id,
            sweep(message).to_sec(),
        )
        self._publish(self._intake.on_lidar(scan))

    def on_cloud(self, message: PointCloud2) -> None:
        """Take a cloud, for `CloudOdometry`."""
        stamp = message.header.stamp
        try:
            points = self._readings.points(message)
            self._swept.watch(message.header.frame_id, times_of(message), *self._motion)
        except CloudError as error:
            self._say(f"{error} The cloud is left out.")
            return
        cloud = SensedCloud(stamp.to_nsec(), self._time.at(stamp.to_sec()), points, message.header.frame_id)
        self._publish(self._intake.on_lidar(cloud))

    def _publish(self, answers: list[Answer]) -> None:
        for stamp_ns, estimate in answers:
            self._motion = math.hypot(*estimate.velocity_xyz), math.hypot(*estimate.rates_rad_s)
            self._give(time_of(stamp_ns), estimate)
