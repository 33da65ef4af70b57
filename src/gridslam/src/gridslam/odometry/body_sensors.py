"""What IMU and range finder tell an odometry, whatever its lidar: lean, motion and height."""

from __future__ import annotations

import math
from typing import Callable, Sequence

import numpy as np

from gridslam.errors import ScanError
from gridslam.inputs.attitude import matrix_of_lean, matrix_of_quaternion
from gridslam.odometry.floor_height import FloorHeight
from gridslam.odometry.inertial import BACK_S, InertialHistory, InertialReading, Lean
from gridslam.odometry.parameters import LidarOdometryParameters

LEVEL = Lean(0.0, 0.0, (0.0, 0.0, 0.0))
"""What counts while the IMU is silent."""


class BodySensors:
    """Takes the readings in the order of their stamps.

    Attributes:
        inertial: the IMU's last readings. height: over the floor of the start. below_m: (3,) m, where the
        newest range ended, in the base frame; None before the first one.
    """

    def __init__(self, parameters: LidarOdometryParameters) -> None:
        self.inertial, self.height = InertialHistory(), FloorHeight(parameters)
        self.below_m: np.ndarray | None = None

    def on_imu(self, reading: InertialReading) -> None:
        """Take a reading of the IMU."""
        if self.inertial.add(reading) and reading.levelled is not None:
            self.height.on_acceleration(reading.stamp_s, float(reading.levelled[2]))

    def on_range(
        self,
        stamp_s: float,
        range_m: float,
        limits_m: tuple[float, float],
        finder_in_base: tuple[Sequence[float], Sequence[float]],
    ) -> None:
        """Take a range of the range finder, which looks along x of its own frame.

        Ranges beyond the limits, NaN and infinite ones do not count, but for -inf: too close (REP-117), as
        under a low UAV that stands. It counts as half the least range. Without the IMU the UAV counts as
        level.

        Args:
            stamp_s: its time.
            range_m: distance.
            limits_m: least and greatest range.
            finder_in_base: its (xyz, quaternion xyzw) in the base frame.
        """
        is_close = range_m == -math.inf and 0.0 < limits_m[0] < math.inf
        if is_close:
            range_m = 0.5 * limits_m[0]
        elif not limits_m[0] <= range_m <= limits_m[1]:
            return
        lean = self.inertial.lean_at(stamp_s) or LEVEL
        x, y, z = finder_in_base[0]
        end = np.array((x, y, z)) + range_m * matrix_of_quaternion(finder_in_base[1])[:, 0]
        below_m = -float((matrix_of_lean(lean.roll_rad, lean.pitch_rad) @ end)[2])
        if below_m > 0.0:
            self.below_m = end
            self.height.on_range(stamp_s, below_m, 0.5 * limits_m[0] if is_close else 0.0)


class BodySensedOdometry:
    """An odometry of any lidar, with IMU and range finder. When the clock jumps back, it begins anew.

    Args:
        body: parameters of what IMU and range finder tell.
        start: x, y in m and yaw in rad of the base in `odom` at the first reading of the lidar.
        say: is called with a sentence when odometry begins anew.

    Raises:
        ScanError: the start makes no sense.
    """

    def __init__(
        self, body: LidarOdometryParameters, start: Sequence[float], say: Callable[[str], None]
    ) -> None:
        self._body, self._start, self._say = body, _checked_start(start), say
        self.reset()

    def reset(self) -> None:
        """Begin anew at the start."""
        self._sensors = BodySensors(self._body)
        self._inertial, self.height = self._sensors.inertial, self._sensors.height
        self._stamp_s: float | None = None  # the newest reading of the lidar
        self._began_s: float | None = None  # the first one
        self._matched_s = -math.inf

    def on_imu(self, reading: InertialReading) -> None:
        """Take a reading of the IMU."""
        if self._inertial.is_back(reading):
            self._go_back(self._inertial.newest_s - reading.stamp_s)
        self._sensors.on_imu(reading)

    def on_range(
        self,
        stamp_s: float,
        range_m: float,
        limits_m: tuple[float, float],
        finder_in_base: tuple[Sequence[float], Sequence[float]],
    ) -> None:
        """Take a range of the range finder; see `BodySensors.on_range`."""
        self._sensors.on_range(stamp_s, range_m, limits_m, finder_in_base)

    def _check_stamp(self, stamp_s: float, what: str) -> None:
        """Check the stamp of the lidar's next reading, a scan or a cloud.

        Raises:
            ScanError: it is not finite, or not newer although the clock did not go back.
        """
        if not math.isfinite(stamp_s):
            raise ScanError(f"The {what}'s stamp must be finite, not {stamp_s}.")
        if self._stamp_s is None or stamp_s > self._stamp_s:
            return
        if self._stamp_s - stamp_s < BACK_S:
            raise ScanError(f"A {what} is not newer than the one before it.")
        self._go_back(self._stamp_s - stamp_s)

    def _go_back(self, seconds: float) -> None:
        self._say(f"The clock jumped back by {seconds:.3f} s; odometry begins anew.")
        self.reset()


def _checked_start(start: Sequence[float]) -> np.ndarray:
    """Return x, y and yaw (3,) of the base at the first reading of the lidar.

    Raises:
        ScanError: they are not three finite numbers.
    """
    pose = np.array(start, dtype=float)
    if pose.shape != (3,) or not np.isfinite(pose).all():
        raise ScanError(f"The odometry's start must be finite x, y, yaw, not {pose.tolist()}.")
    return pose
