"""Orders the readings of lidar, IMU and range finder for the lidar odometry."""

from __future__ import annotations

import math
from collections import deque
from typing import Callable, Generic, NamedTuple, Protocol, Sequence, TypeVar

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


class BodyOdometry(Protocol):
    """An odometry that takes the IMU's readings and the ranges, whatever its lidar gives."""

    def on_imu(self, reading: InertialReading) -> None:
        """Take a reading of the IMU."""

    def on_range(
        self, stamp_s: float, range_m: float, limits_m: tuple[float, float], finder_in_base: Mounting
    ) -> None:
        """Take a range; see `BodySensors.on_range`."""


Odometry = TypeVar("Odometry", bound=BodyOdometry)
Told = TypeVar("Told", contravariant=True)


class Sensed(Protocol[Told]):
    """What a lidar gives at one instant: a scan or a cloud. It knows how its odometry takes it."""

    @property
    def stamp_ns(self) -> int:
        """Tells one from another, exactly."""

    @property
    def stamp_s(self) -> float:
        """The same in s."""

    @property
    def frame(self) -> str:
        """Of the lidar."""

    @property
    def kind(self) -> str:
        """A word for the user: scan, cloud."""

    def tell(self, odometry: Told, lidar_in_base: Mounting) -> OdometryEstimate:
        """Give it to the odometry, and return the estimate; raises ScanError if it makes no sense."""


class SensedScan(NamedTuple):
    """A scan as a lidar gives it."""

    stamp_ns: int
    stamp_s: float
    ranges: np.ndarray
    """(n,) m."""
    angles_rad: tuple[float, float]
    """Of the first beam, and from beam to beam."""
    limits_m: tuple[float, float]
    frame: str
    lasts_s: float = 0.0
    """From the first beam, which the stamp is of, to the last."""

    @property
    def kind(self) -> str:
        """See `Sensed`."""
        return "scan"

    def tell(self, odometry: LidarOdometry, lidar_in_base: Mounting) -> OdometryEstimate:
        """See `Sensed`."""
        return odometry.on_scan(
            self.stamp_s, self.ranges, self.angles_rad, self.limits_m, lidar_in_base, self.lasts_s
        )


class SensedRange(NamedTuple):
    """What a range finder measured."""

    range_m: float
    limits_m: tuple[float, float]
    frame: str
    """Of the range finder, which looks along its x axis."""


class Answer(NamedTuple):
    """The odometry at the stamp of a scan or a cloud."""

    stamp_ns: int
    estimate: OdometryEstimate


class OdometryIntake(Generic[Odometry]):
    """Gives the odometry every reading in the order of the stamps, whichever came first.

    What holds for a scan holds for a cloud. It waits for a reading of the IMU that is at most ``imu_lag_s``
    older, unless the IMU is silent. The first such reading is the last one that counts for it. `RangeQueue`
    does the same with ranges. A scan waits until the next scan comes at most. The very first one waits for
    both sensors. So the estimates depend on the readings alone, not on their order. Every call returns the
    answers that are due.

    Args:
        odometry: takes the sensors' readings.
        mount_of: frame of a sensor -> its pose in the base frame; raises SlamError while it is not known.
        say: is called with a sentence about each reading that is left out.
        imu_lag_s: a little more than the IMU's period.
    """

    def __init__(
        self,
        odometry: Odometry,
        mount_of: Callable[[str], Mounting],
        say: Callable[[str], None],
        imu_lag_s: float = IMU_LAG_S,
    ) -> None:
        self._odometry, self._mount_of, self._say = odometry, mount_of, say
        self._imu_lag_s = imu_lag_s
        self._sensed: Sensed[Odometry] | None = None
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

    def on_lidar(self, sensed: Sensed[Odometry]) -> list[Answer]:
        """Take a scan or a cloud. One that still waits is used first.

        One that comes again gets the same answer.
        """
        if self._answered is not None and sensed.stamp_ns == self._answered.stamp_ns:
            return [self._answered]
        is_next = self._sensed is not None and sensed.stamp_ns != self._sensed.stamp_ns
        answers = self._answer() if is_next else []
        self._sensed = sensed
        return answers + self._answer_if_ready()

    def _answer_if_ready(self) -> list[Answer]:
        if self._sensed is None or self._must_wait(self._sensed.stamp_s):
            return []
        return self._answer()

    def _must_wait(self, stamp_s: float) -> bool:
        """Whether a reading of the IMU or a range is still to come."""
        if self._answered is None and (self._imu_s is None or not self._ranges.has_begun):
            return True
        lacks_imu = self._imu_s is not None and self._imu_lag_s < stamp_s - self._imu_s < SILENT_S
        return lacks_imu or self._ranges.lacks(stamp_s)

    def _answer(self) -> list[Answer]:
        """Return the answer to what waits; none if it cannot be used."""
        sensed, self._sensed = self._sensed, None
        assert sensed is not None  # the callers have looked
        self._use_readings(sensed.stamp_s - self._imu_lag_s)
        self._use_ranges(sensed.stamp_s)
        try:
            estimate = sensed.tell(self._odometry, self._mount_of(sensed.frame))
        except SlamError as error:
            self._say(f"{error} The {sensed.kind} is left out.")
            return []
        if estimate.remark:
            self._say(estimate.remark)
        self._answered = Answer(sensed.stamp_ns, estimate)
        return [self._answered]

    def _use_readings(self, until_s: float) -> None:
        """Use the readings up to the first one that is not older than a time."""
        while self._readings:
            reading = self._readings.popleft()
            self._odometry.on_imu(reading)
            if reading.stamp_s >= until_s:
                return

    def _use_ranges(self, until_s: float) -> None:
        for stamp_s, sensed in self._ranges.take(until_s):
            try:
                place = self._mount_of(sensed.frame)
                self._odometry.on_range(stamp_s, sensed.range_m, sensed.limits_m, place)
            except SlamError as error:
                self._say(f"{error} The range is left out.")
