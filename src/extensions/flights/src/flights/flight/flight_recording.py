"""The recording of a flight for SLAM: every scan, odometry with the attitude, and the truth.

One recorded flight serves every variant of SLAM. The ground truth steers it, so it does not depend on SLAM.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator, NamedTuple, Sequence

import numpy as np

from simulation_tools.geometry import Pose
from simulation_tools.sensors.lidar import Lidar


@dataclass(frozen=True)
class LidarGeometry:
    """The lidar of a recording. position_m, orientation_xyzw: of its frame in the base frame."""

    angle_min_rad: float
    angle_increment_rad: float
    range_min_m: float
    range_max_m: float
    position_m: tuple
    orientation_xyzw: tuple

    @classmethod
    def of(cls, lidar: Lidar) -> LidarGeometry:
        """Return the geometry of a simulated lidar."""
        pose = lidar.pose_in_body
        ranges = lidar.range_min, lidar.range_max
        return cls(lidar.angle_min, lidar.angle_increment, *ranges, pose.position_m, pose.orientation_xyzw)


class RecordedScan(NamedTuple):
    """One instant: ranges (beams,) by REP-117; the base frame's poses in `odom` and in `world`."""

    t_s: float
    ranges: np.ndarray
    odometry: Pose
    truth: Pose


@dataclass(frozen=True)
class FlightRecording:
    """The scans of one flight in the order of time.

    times_s: (n,). ranges_m: (n, beams) float32. odometry, truth: (n, 7) of position and quaternion xyzw in
    `odom` and in `world`. name: of the flight, for titles and file names.
    """

    name: str
    lidar: LidarGeometry
    times_s: np.ndarray
    ranges_m: np.ndarray
    odometry: np.ndarray
    truth: np.ndarray

    def __len__(self) -> int:
        return len(self.times_s)

    def __iter__(self) -> Iterator[RecordedScan]:
        rows = zip(self.times_s.tolist(), self.ranges_m, self.odometry.tolist(), self.truth.tolist())
        for t_s, ranges, odometry, truth in rows:
            yield RecordedScan(t_s, ranges, _pose(odometry), _pose(truth))

    def one_of(self, scans: int) -> FlightRecording:
        """Return a recording of every n-th scan, like that of a slower lidar. scans: this n."""
        rows = slice(None, None, scans)
        series = (self.times_s[rows], self.ranges_m[rows], self.odometry[rows], self.truth[rows])
        return FlightRecording(self.name, self.lidar, *series)


class FlightRecorder:
    """Keeps the scans of a closed loop (`ClosedLoop.listeners`)."""

    def __init__(self, name: str, lidar: Lidar) -> None:
        self._name, self._lidar = name, LidarGeometry.of(lidar)
        self._scans: list[RecordedScan] = []

    def on_scan(self, t_s: float, ranges: np.ndarray, odometry: Pose, truth: Pose) -> None:
        """Keep a scan."""
        self._scans.append(RecordedScan(t_s, np.array(ranges, dtype=np.float32), odometry, truth))

    def recording(self) -> FlightRecording:
        """Return everything recorded so far."""
        scans = self._scans
        return FlightRecording(
            self._name,
            self._lidar,
            np.array([scan.t_s for scan in scans]),
            np.array([scan.ranges for scan in scans], dtype=np.float32),
            np.array([_row(scan.odometry) for scan in scans]).reshape(-1, 7),
            np.array([_row(scan.truth) for scan in scans]).reshape(-1, 7),
        )


def _row(pose: Pose) -> tuple:
    return (*pose.position_m, *pose.orientation_xyzw)


def _pose(row: Sequence[float]) -> Pose:
    x, y, z, qx, qy, qz, qw = row
    return Pose((x, y, z), (qx, qy, qz, qw))
