"""Orders the messages of lidar, IMU and range finder for the lidar odometry."""

from __future__ import annotations

import math
from collections import deque
from typing import Callable

import numpy as np
from genpy import Time
from sensor_msgs.msg import Imu, LaserScan, Range

from gridslam import ScanError, SlamError
from gridslam.odometry import LidarOdometry, OdometryEstimate
from gridslam.odometry.inertial import SILENT_S, InertialReading
from gridslam.odometry.range_queue import RangeQueue
from gridslam_ros.odometry_frames import Pose
from node_tools.conversions import xyz, xyzw

READINGS_KEPT = 100
"""Of the IMU, without a scan."""


class OdometryFeed:
    """Gives the odometry every message in the order of the stamps, whichever came first.

    A scan waits for a reading of the IMU that is at most ``imu_lag_s`` older, unless the IMU is silent. The
    first such reading is the last one that counts for it. `RangeQueue` does the same with ranges. A scan
    waits until the next scan comes at most. The very first one waits for both sensors. So the estimates
    depend on the messages alone, not on their order.

    Args:
        odometry: takes the sensors' readings.
        mount: frame of a sensor -> its pose in the base frame; raises SlamError if TF does not know it.
        imu_lag_s: a little more than the IMU's period.
        publish: is called with each estimate and the exact stamp of its scan.
        say: is called with a sentence about each message that is left out.
    """

    def __init__(
        self,
        odometry: LidarOdometry,
        mount: Callable[[str], Pose],
        imu_lag_s: float,
        publish: Callable[[Time, OdometryEstimate], None],
        say: Callable[[str], None],
    ) -> None:
        self._odometry, self._mount, self._imu_lag_s = odometry, mount, imu_lag_s
        self._publish, self._say = publish, say
        self._scan: LaserScan | None = None
        self._answered: tuple[Time, OdometryEstimate] | None = None
        self._imu_s: float | None = None
        self._imu_began_s = math.inf
        self._readings: deque[InertialReading] = deque()
        self._ranges = RangeQueue()

    def on_imu(self, message: Imu) -> None:
        """Take the attitude, the rates and, if it is measured, the specific force.

        Of the first instant the force does not count.
        """
        stamp_s = message.header.stamp.to_sec()
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
        if self._imu_s is not None and reading.stamp_s < self._imu_s:
            self._use_readings(math.inf)  # the clock went back
        self._imu_s = reading.stamp_s
        self._readings.append(reading)
        if len(self._readings) > READINGS_KEPT:
            self._odometry.on_imu(self._readings.popleft())
        self._process_if_ready()

    def on_range(self, message: Range) -> None:
        """Take a range."""
        self._ranges.add(message.header.stamp.to_sec(), message)
        self._process_if_ready()

    def on_scan(self, message: LaserScan) -> None:
        """Take a scan. One that still waits is used first."""
        if self._answered is not None and message.header.stamp == self._answered[0]:
            self._publish(*self._answered)  # simulators in lockstep send the same scan again
            return
        if self._scan is not None and message.header.stamp != self._scan.header.stamp:
            self._process()
        self._scan = message
        self._process_if_ready()

    def _process_if_ready(self) -> None:
        if self._scan is not None and not self._must_wait(self._scan.header.stamp.to_sec()):
            self._process()

    def _must_wait(self, stamp_s: float) -> bool:
        """Whether a reading of the IMU or a range for a scan is still to come."""
        if self._answered is None and (self._imu_s is None or not self._ranges.has_begun):
            return True
        lacks_imu = self._imu_s is not None and self._imu_lag_s < stamp_s - self._imu_s < SILENT_S
        return lacks_imu or self._ranges.lacks(stamp_s)

    def _process(self) -> None:
        scan, self._scan = self._scan, None
        assert scan is not None  # the callers have looked
        self._use_readings(scan.header.stamp.to_sec() - self._imu_lag_s)
        self._use_ranges(scan.header.stamp.to_sec())
        try:
            estimate = self._odometry.on_scan(
                scan.header.stamp.to_sec(),
                np.asarray(scan.ranges, float),
                (scan.angle_min, scan.angle_increment),
                (scan.range_min, scan.range_max),
                self._mount(scan.header.frame_id),
            )
        except SlamError as error:
            self._say(f"{error} The scan is left out.")
            return
        if estimate.remark:
            self._say(estimate.remark)
        self._answered = scan.header.stamp, estimate
        self._publish(*self._answered)

    def _use_readings(self, until_s: float) -> None:
        """Use the readings up to the first one that is not older than a time."""
        while self._readings:
            reading = self._readings.popleft()
            self._odometry.on_imu(reading)
            if reading.stamp_s >= until_s:
                return

    def _use_ranges(self, scan_s: float) -> None:
        for stamp_s, message in self._ranges.take(scan_s):
            try:
                self._odometry.on_range(
                    stamp_s,
                    message.range,
                    (message.min_range, message.max_range),
                    self._mount(message.header.frame_id),
                )
            except SlamError as error:
                self._say(f"{error} The range is left out.")
