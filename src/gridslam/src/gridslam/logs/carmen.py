"""Logs of the CARMEN toolkit, the format of the field's classic datasets.

Each line is a message: its name, its numbers, then ipc_timestamp, host name, logger_timestamp. FLASER,
ROBOTLASER1 and ODOM are read. Other messages (PARAM, SYNC, ...) and comments are skipped; those of other
lidars (RAWLASER1, RLASER, ROBOTLASER2, ...) can be counted.
"""

from __future__ import annotations

import codecs
import gzip
import io
import math
import re
import zlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO, Callable, Iterator, cast

import numpy as np

from gridslam.errors import SlamError, reason_of
from gridslam.inputs.attitude import matrix_of_quaternion, roll_pitch_yaw_of
from gridslam.inputs.scan_projection import project
from gridslam.scan import PlanarScan

RANGE_MIN_M = 0.02
"""The logs do not give the lidar's least range; a shorter reading is none."""
RANGE_MAX_M = 80.0
"""FLASER does not give the lidar's range, nor does a ROBOTLASER1 that says 0; this is the SICK LMS's."""
NO_STAMP = ["0", "nohost", "0"]
"""The end of a message, where a log lacks it and its stamps are not used."""
NOT_A_NUMBER = {"#QNAN": math.nan, "#SNAN": math.nan, "#IND": math.nan, "#INF": math.inf}
"""What programs of Microsoft's compiler write behind ``1.`` or ``-1.`` for readings that are no numbers."""
NO_RETURN_BEYOND_M = 1.83
"""The SICK reports 81.83 for no return."""
STEPS_DEG = {180: 1.0, 181: 1.0, 360: 0.5, 361: 0.5, 401: 0.25, 541: 0.5, 1081: 0.25}
"""Number of readings -> degrees from beam to beam, by CARMEN's convention."""

OF_A_LIDAR = re.compile(r"[A-Z]*LASER\d*(_REMISSION)?")
GZIP_BEGIN, SNIFFED_BYTES = b"\x1f\x8b", 4096
BYTE_ORDER_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
"""First bytes of a text that an editor, or PowerShell's ">", has written -> its encoding."""

STAMPS_MIN = 10
"""A log is judged by the stamps of so many scans."""


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
    path: str | Path,
    range_max_m: float | None = None,
    on_bad: Callable[[CarmenError], None] | None = None,
    period_s: float | None = None,
    on_other_lidar: Callable[[str], None] | None = None,
) -> Iterator[CarmenScan | CarmenOdometry]:
    """Yield the scans and odometry of a log (plain or .gz) in its order.

    Args:
        path: of the log.
        range_max_m: the lidar's range; None: 80 m for FLASER, the message's for ROBOTLASER1.
        on_bad: is told of each line that cannot be understood, which is then left out; None: it is raised.
        period_s: the log's stamps are not used: scans are so many seconds apart, and a reading of odometry
            is half of that after the scan before; None: the stamps are the log's.
        on_other_lidar: is told the name of each message of a lidar that is skipped.

    Raises:
        CarmenError: the file cannot be read, or a line cannot be understood; names both.
    """
    readers: dict[str, Callable[[list[str], float | None], CarmenScan | CarmenOdometry]] = {
        "FLASER": _flaser,
        "ROBOTLASER1": _robot_laser,
        "ODOM": _odometry,
    }
    scans = 0
    for number, line in enumerate(_lines(path), start=1):
        words = line.split()
        if not words or words[0] not in readers:
            if words and on_other_lidar and OF_A_LIDAR.fullmatch(words[0]):
                on_other_lidar(words[0])
            continue
        if period_s is not None:
            words += NO_STAMP  # they count only where the line has none itself
        try:
            record = readers[words[0]](words[1:], range_max_m)
            is_scan = isinstance(record, CarmenScan)
            scans += is_scan
            if period_s is not None:
                record = replace(record, stamp_s=period_s * (scans if is_scan else scans + 0.5))
            yield record
        except (ValueError, IndexError):
            error = CarmenError(
                f"{path}:{number}: this {words[0]} message is incomplete or holds what is not a number."
            )
            if on_bad is None:
                raise error from None
            on_bad(error)


class StampOrder:
    """Finds a log whose scans have no stamps, or rounded ones.

    Args:
        path: of the log.
    """

    def __init__(self, path: str | Path) -> None:
        self._path = path
        self._scans = self._behind = 0
        self._newest_s = -math.inf

    def add(self, stamp_s: float) -> None:
        """Take in the stamp of the next scan.

        Raises:
            CarmenError: most of the stamps do not ascend.
        """
        self._scans += 1
        self._behind += stamp_s <= self._newest_s
        self._newest_s = max(self._newest_s, stamp_s)
        if self._scans >= STAMPS_MIN and 2 * self._behind > self._scans:
            raise CarmenError(
                f"The stamps of {self._behind} of the first {self._scans} scans in {self._path} do not "
                "ascend: the log has none, or they are rounded; tell the time from scan to scan (--period S)."
            )


def planar_scans(
    path: str | Path,
    lidar_in_base: tuple[float, float, float] = (0.0, 0.0, 0.0),
    period_s: float | None = None,
) -> Iterator[tuple[PlanarScan, tuple[float, float, float]]]:
    """Yield a log's scans with the base in odom (x, y, yaw), the input of the filter, bit for bit as its bag.

    A bag holds ranges and angles in 32 bits, and orientations as quaternions. A rounding of the last bit
    would lead the particles elsewhere. Each stamp is yielded once, in ascending order.

    Args:
        path: of the log.
        lidar_in_base: pose of the lidar on the robot, x, y in m and yaw in rad.
        period_s: see `read_log`.

    Raises:
        CarmenError: as `read_log`, or most of the stamps do not ascend.
    """
    order = StampOrder(path)
    last_s, range_min_m = -math.inf, float(np.float32(RANGE_MIN_M))
    mounting = ((*lidar_in_base[:2], 0.0), _quaternion(lidar_in_base[2]))
    for scan in read_log(path, period_s=period_s):
        if not isinstance(scan, CarmenScan):
            continue
        order.add(scan.stamp_s)
        if scan.stamp_s <= last_s:
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
    _, angle_min_rad, span_rad, angle_increment_rad, greatest_m = _floats(words[:5], 5)
    count = int(words[7])
    if angle_increment_rad == 0.0 and count > 1:
        angle_increment_rad = span_rad / (count - 1)
    if greatest_m <= 0.0:
        greatest_m = RANGE_MAX_M
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
    ranges_m = np.array([_reading(word) for word in readings])
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


def _reading(word: str) -> float:
    """Return a reading as a number, which may be infinite or NaN; ValueError if it is none."""
    if "#" in word:
        return NOT_A_NUMBER.get(word.lstrip("+-")[2:].rstrip("0").upper(), math.nan)
    return float(word)


def _floats(words: list[str], count: int) -> list[float]:
    """Return the words as finite numbers; ValueError if they are not, or not so many."""
    numbers = [float(word) for word in words]
    if len(numbers) != count or not all(math.isfinite(number) for number in numbers):
        raise ValueError
    return numbers


def _lines(path: str | Path) -> Iterator[str]:
    try:
        with _opened(path) as start:
            encoding = _encoding(path, start.read(SNIFFED_BYTES))
        with _opened(path) as binary, io.TextIOWrapper(binary, encoding) as lines:
            yield from lines
    except (OSError, EOFError, UnicodeError, zlib.error) as error:
        raise CarmenError(f"The log {path} cannot be read: {reason_of(error)}.") from None


def _opened(path: str | Path) -> BinaryIO:
    """Open a log's bytes. A packed one is known by its ending, or by its first bytes."""
    with open(path, "rb") as file:
        is_packed = str(path).endswith(".gz") or file.read(len(GZIP_BEGIN)) == GZIP_BEGIN
    return cast(BinaryIO, gzip.open(path) if is_packed else open(path, "rb"))


def _encoding(path: str | Path, begin: bytes) -> str:
    """Return how a log's text is encoded, by its first bytes.

    Raises:
        CarmenError: it is no text.
    """
    for mark, encoding in BYTE_ORDER_MARKS.items():
        if begin.startswith(mark):
            return encoding
    if b"\0" in begin:
        raise CarmenError(
            f"The log {path} is not a text of CARMEN: it holds bytes of zero (a log in UTF-16 without its "
            "mark is made readable by iconv -f UTF-16LE -t UTF-8)."
        )
    # Only names of hosts and comments can hold other than ASCII, in whatever encoding.
    return "latin-1"


def _quaternion(yaw_rad: float) -> tuple[float, float, float, float]:
    return 0.0, 0.0, math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad)


def _numbers(*values: float) -> str:
    return " ".join(f"{value:.6f}" for value in values)


def _ending(stamp_s: float) -> str:
    return f"{stamp_s:.6f} nohost {stamp_s:.6f}"
