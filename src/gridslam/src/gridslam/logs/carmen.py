"""Logs of the CARMEN toolkit, the format of the field's classic datasets.

Each line is a message: its name, its numbers, then ipc_timestamp, host name, logger_timestamp. FLASER,
ROBOTLASER1 and ODOM are read. Other messages (PARAM, SYNC, RLASER, ...) and comments are skipped.
"""

from __future__ import annotations

import gzip
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Iterator

import numpy as np

from gridslam.errors import SlamError, reason_of
from gridslam.inputs.attitude import matrix_of_quaternion, roll_pitch_yaw_of
from gridslam.inputs.scan_projection import project
from gridslam.scan import PlanarScan

RANGE_MIN_M = 0.02
"""The logs do not give the lidar's least range; a shorter reading is none."""
RANGE_MAX_M = 80.0
"""FLASER does not give the lidar's range; this is the SICK LMS's."""
NO_RETURN_BEYOND_M = 1.83
"""The SICK reports 81.83 for no return."""
STEPS_DEG = {180: 1.0, 181: 1.0, 360: 0.5, 361: 0.5, 401: 0.25, 541: 0.5, 1081: 0.25}
"""Number of readings -> degrees from beam to beam, by CARMEN's convention."""


class CarmenError(SlamError):
    """A log that cannot be read or written."""


@dataclass(frozen=True, eq=False)
class CarmenScan:
    """One scan with the odometry's poses of robot and lidar."""

    stamp_s: float
    """s: the ipc_timestamp."""
    ranges_m: np.ndarray
    """(n,) +inf where the reading is beyond range_max_m, NaN where it is no number."""
    angle_min_rad: float
    angle_increment_rad: float
    range_max_m: float
    robot_in_odom: tuple[float, float, float]
    """x, y in m, yaw in rad."""
    lidar_in_odom: tuple[float, float, float]
    """x, y in m, yaw in rad."""


@dataclass(frozen=True)
class CarmenOdometry:
    """One reading of odometry."""

    stamp_s: float
    robot_in_odom: tuple[float, float, float]
    """x, y in m, yaw in rad."""
    speed_mps: float
    turn_rate_radps: float


def flaser_angles(count: int) -> tuple[float, float]:
    """Return (angle_min, angle_increment) in rad of a FLASER message with this many readings."""
    step_rad = math.radians(STEPS_DEG[count]) if count in STEPS_DEG else math.pi / count
    span_deg = {401: 100.0, 541: 270.0, 1081: 270.0}.get(count, 180.0)
    return -math.radians(span_deg) / 2.0, step_rad


def read_log(
    path: str | Path, range_max_m: float | None = None, on_bad: Callable[[CarmenError], None] | None = None
) -> Iterator[CarmenScan | CarmenOdometry]:
    """Yield the scans and odometry of a log (plain or .gz) in its order.

    Args:
        path: of the log.
        range_max_m: the lidar's range; None: 80 m for FLASER, the message's for ROBOTLASER1.
        on_bad: is told of each line that cannot be understood, which is then left out; None: it is raised.

    Raises:
        CarmenError: the file cannot be read, or a line cannot be understood; names both.
    """
    readers: dict[str, Callable[[list[str], float | None], CarmenScan | CarmenOdometry]] = {
        "FLASER": _flaser,
        "ROBOTLASER1": _robot_laser,
        "ODOM": _odometry,
    }
    for number, line in enumerate(_lines(path), start=1):
        words = line.split()
        if not words or words[0] not in readers:
            continue
        try:
            yield readers[words[0]](words[1:], range_max_m)
        except (ValueError, IndexError):
            error = CarmenError(
                f"{path}:{number}: this {words[0]} message is incomplete or holds what is not a number."
            )
            if on_bad is None:
                raise error from None
            on_bad(error)


def planar_scans(
    path: str | Path, lidar_in_base: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> Iterator[tuple[PlanarScan, tuple[float, float, float]]]:
    """Yield a log's scans with the base in odom (x, y, yaw), the input of the filter, bit for bit as its bag.

    A bag holds ranges and angles in 32 bits, and orientations as quaternions. A rounding of the last bit
    would lead the particles elsewhere. Each stamp is yielded once, in ascending order.

    Args:
        path: of the log.
        lidar_in_base: pose of the lidar on the robot, x, y in m and yaw in rad.
    """
    last_s, range_min_m = -math.inf, float(np.float32(RANGE_MIN_M))
    mounting = ((*lidar_in_base[:2], 0.0), _quaternion(lidar_in_base[2]))
    for scan in read_log(path):
        if not isinstance(scan, CarmenScan) or scan.stamp_s <= last_s:
            continue
        last_s = scan.stamp_s
        planar = project(
            scan.ranges_m.astype(np.float32),
            float(np.float32(scan.angle_min_rad)),
            float(np.float32(scan.angle_increment_rad)),
            range_min_m,
            scan.range_max_m,
            mounting,
            stamp_s=last_s,
        )
        x, y, yaw = scan.robot_in_odom
        yield planar, (x, y, roll_pitch_yaw_of(matrix_of_quaternion(_quaternion(yaw)))[2])


def format_scan(scan: CarmenScan) -> str:
    """Return the scan as a line: FLASER if its convention fits, else ROBOTLASER1."""
    range_max_m = scan.range_max_m if math.isfinite(scan.range_max_m) else _greatest_m(scan.ranges_m)
    far_m = range_max_m + NO_RETURN_BEYOND_M
    invalid = np.isnan(scan.ranges_m) | np.isneginf(scan.ranges_m)
    readings = np.where(invalid, 0.0, np.minimum(scan.ranges_m, far_m))
    ranges = " ".join(f"{reading:.3f}" for reading in readings)
    poses = _numbers(*scan.lidar_in_odom, *scan.robot_in_odom)
    convention = flaser_angles(readings.size)
    if np.allclose((scan.angle_min_rad, scan.angle_increment_rad), convention, atol=1e-5, rtol=0.0):
        return f"FLASER {readings.size} {ranges} {poses} {_ending(scan.stamp_s)}"
    span_rad = scan.angle_increment_rad * (readings.size - 1)
    facts = _numbers(scan.angle_min_rad, span_rad, scan.angle_increment_rad, range_max_m, 0.01)
    return (
        f"ROBOTLASER1 0 {facts} 0 {readings.size} {ranges} 0 {poses} {_numbers(0, 0, 0, 0, 0)} "
        f"{_ending(scan.stamp_s)}"
    )


def _greatest_m(ranges_m: np.ndarray) -> float:
    """Return a greatest range for a lidar that has none: the SICK's, or that of its farthest return."""
    return max(RANGE_MAX_M, float(np.max(ranges_m, initial=0.0, where=np.isfinite(ranges_m))))


def format_odometry(odometry: CarmenOdometry) -> str:
    """Return the reading as an ODOM line."""
    values = _numbers(*odometry.robot_in_odom, odometry.speed_mps, odometry.turn_rate_radps, 0.0)
    return f"ODOM {values} {_ending(odometry.stamp_s)}"


def _flaser(words: list[str], range_max_m: float | None) -> CarmenScan:
    count = int(words[0])
    poses = _floats(words[1 + count : 7 + count], 6)
    return _scan(
        words[1 : 1 + count], flaser_angles(count), range_max_m or RANGE_MAX_M, poses, words[7 + count]
    )


def _robot_laser(words: list[str], range_max_m: float | None) -> CarmenScan:
    _, angle_min_rad, _, angle_increment_rad, greatest_m = _floats(words[:5], 5)
    count = int(words[7])
    remissions = int(words[8 + count])
    after = 9 + count + remissions
    poses = _floats(words[after : after + 6], 6)
    angles = (angle_min_rad, angle_increment_rad)
    return _scan(words[8 : 8 + count], angles, range_max_m or greatest_m, poses, words[-3])


def _odometry(words: list[str], _range_max_m: float | None) -> CarmenOdometry:
    x, y, yaw, speed, turn_rate, _, stamp_s = _floats(words[:7], 7)
    return CarmenOdometry(stamp_s, (x, y, yaw), speed, turn_rate)


def _scan(
    readings: list[str], angles: tuple[float, float], range_max_m: float, poses: list[float], stamp: str
) -> CarmenScan:
    ranges_m = np.array([float(reading) for reading in readings])
    if not ranges_m.size:
        raise ValueError
    ranges_m[ranges_m > range_max_m] = np.inf
    return CarmenScan(
        stamp_s=_floats([stamp], 1)[0],
        ranges_m=ranges_m,
        angle_min_rad=angles[0],
        angle_increment_rad=angles[1],
        range_max_m=range_max_m,
        robot_in_odom=(poses[3], poses[4], poses[5]),
        lidar_in_odom=(poses[0], poses[1], poses[2]),
    )


def _floats(words: list[str], count: int) -> list[float]:
    """Return the words as finite numbers; ValueError if they are not, or not so many."""
    numbers = [float(word) for word in words]
    if len(numbers) != count or not all(math.isfinite(number) for number in numbers):
        raise ValueError
    return numbers


def _lines(path: str | Path) -> Iterator[str]:
    try:
        # Only names of hosts and comments can hold other than ASCII, in whatever encoding.
        with (gzip.open if str(path).endswith(".gz") else open)(path, "rt", encoding="latin-1") as lines:
            yield from lines
    except (OSError, EOFError) as error:
        raise CarmenError(f"The log {path} cannot be read: {reason_of(error)}.") from None


def _quaternion(yaw_rad: float) -> tuple[float, float, float, float]:
    return 0.0, 0.0, math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad)


def _numbers(*values: float) -> str:
    return " ".join(f"{value:.6f}" for value in values)


def _ending(stamp_s: float) -> str:
    return f"{stamp_s:.6f} nohost {stamp_s:.6f}"
