"""Orders the readings of lidar, IMU and range finder for the lidar odometry."""

from __future__ import annotations

import math
from collections import deque
from typing import Callable, NamedTuple, Sequence

import numpy as np

from gridslam.errors import SlamError
from gridslam.odometry.inertial import SILENT_S, InertialReading
from gridslam.odometry.lidar_odometry import LidarOdometry, OdometryEstimate
from gridslam.odometry.range_queue import RangeQueue

READINGS_KEPT = 100
"""Of the IMU, without a scan."""
IMU_LAG_S = 0.0205
"""A little more than the period of an IMU at 50 Hz, as MAVROS sends it."""

Mounting = tuple[Sequence[float], Sequence[float]]
"""Of a sensor in the base frame: translation (x, y, z) in m, and unit quaternion (x, y, z, w)."""


class SensedScan(NamedTuple):
    """A scan as a lidar gives it."""

    stamp_ns: int
    """Tells scans apart, exactly."""
    stamp_s: float
    ranges: np.ndarray
    """(n,) m."""
    angles_rad: tuple[float, float]
    """Of the first beam, and from beam to beam."""
    limits_m: tuple[float, float]
    frame: str
    """Of the lidar."""


class SensedRange(NamedTuple):
    """What a range finder measured."""

    range_m: float
    limits_m: tuple[float, float]
    frame: str
    """Of the range finder, which looks along its x axis."""


class Answer(NamedTuple):
    """The odometry at a scan's stamp."""

    stamp_ns: int
    estimate: OdometryEstimate


class OdometryIntake:
    """Gives the odometry every reading in the order of the stamps, whichever came first.

    A scan waits for a reading of the IMU that is at most ``imu_lag_s`` older, unless the IMU is silent. The
    first such reading is the last one that counts for it. `RangeQueue` does the same with ranges. A scan
    waits until the next scan comes at most. The very first one waits for both sensors. So the estimates
    depend on the readings alone, not on their order. Every call returns the answers that are due.

    Args:
        odometry: takes the sensors' readings.
        mount_of: frame of a sensor -> its pose in the base frame; raises SlamError while it is not known.
        say: is called with a sentence about each reading that is left out.
        imu_lag_s: a little more than the IMU's period.
    """

    def __init__(
        self,
        odometry: LidarOdometry,
        mount_of: Callable[[str], Mounting],
        say: Callable[[str], None],
        imu_lag_s: float = IMU_LAG_S,
    ) -> None:
        self._odometry, self._mount_of, self._say = odometry, mount_of, say
        self._imu_lag_s = imu_lag_s
        self._scan: SensedScan | None = None
        self._answered: Answer | None = None
        self._imu_s: float | None = None
        self._readings: deque[InertialReading] = deque()
        self._ranges = RangeQueue()

    def on_imu(self, reading: InertialReading) -> list[Answer]:
        """Take a reading of the IMU."""
        if self._imu_s is not None and reading.stamp_s < self._imu_s:
            self._use_readings(math.inf)  # the clock went back
        self._imu_s = reading.stamp_s
        self._readings.append(reading)
        if len(self._readings) > READINGS_KEPT:
            self._odometry.on_imu(self._readings.popleft())
        return self._answer_if_ready()

    def on_range(self, stamp_s: float, sensed: SensedRange) -> list[Answer]:
        """Take a range."""
        self._ranges.add(stamp_s, sensed)
        return self._answer_if_ready()

    def on_scan(self, scan: SensedScan) -> list[Answer]:
        """Take a scan. One that still waits is used first. One that comes again gets the same answer."""
        if self._answered is not None and scan.stamp_ns == self._answered.stamp_ns:
            return [self._answered]
        is_next = self._scan is not None and scan.stamp_ns != self._scan.stamp_ns
        answers = self._answer() if is_next else []
        self._scan = scan
        return answers + self._answer_if_ready()

    def _answer_if_ready(self) -> list[Answer]:
        if self._scan is None or self._must_wait(self._scan.stamp_s):
            return []
        return self._answer()

    def _must_wait(self, stamp_s: float) -> bool:
        """Whether a reading of the IMU or a range for a scan is still to come."""
        if self._answered is None and (self._imu_s is None or not self._ranges.has_begun):
            return True
        lacks_imu = self._imu_s is not None and self._imu_lag_s < stamp_s - self._imu_s < SILENT_S
        return lacks_imu or self._ranges.lacks(stamp_s)

    def _answer(self) -> list[Answer]:
        """Return the answer to the scan that waits; none if it cannot be used."""
        scan, self._scan = self._scan, None
        assert scan is not None  # the callers have looked
        self._use_readings(scan.stamp_s - self._imu_lag_s)
        self._use_ranges(scan.stamp_s)
        try:
            estimate = self._odometry.on_scan(
                scan.stamp_s, scan.ranges, scan.angles_rad, scan.limits_m, self._mount_of(scan.frame)
            )
        except SlamError as error:
            self._say(f"{error} The scan is left out.")
            return []
        if estimate.remark:
            self._say(estimate.remark)
        self._answered = Answer(scan.stamp_ns, estimate)
        return [self._answered]

    def _use_readings(self, until_s: float) -> None:
        """Use the readings up to the first one that is not older than a time."""
        while self._readings:
            reading = self._readings.popleft()
            self._odometry.on_imu(reading)
            if reading.stamp_s >= until_s:
                return

    def _use_ranges(self, scan_s: float) -> None:
        for stamp_s, sensed in self._ranges.take(scan_s):
            try:
                place = self._mount_of(sensed.frame)
                self._odometry.on_range(stamp_s, sensed.range_m, sensed.limits_m, place)
            except SlamError as error:
                self._say(f"{error} The range is left out.")
