"""SLAM run on a flight without ROS: beside the closed loop as it flies, or on its recording."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, NamedTuple, Sequence

import numpy as np

from flights.flight.flight_log import POSE_COLUMNS, Series
from flights.flight.flight_recording import FlightRecording, LidarGeometry
from flights.worlds.floor_plan import outlines_of_file
from flights.worlds.true_walls import seen_faces
from gridslam import OccupancyGrid, ScanError
from gridslam.evaluation import Walls
from gridslam.inputs.levelling import Levelling
from gridslam.inputs.scan_watch import ScanWatch
from gridslam.level_cloud import LevelCloud
from gridslam.session import SlamSession
from gridslam.trajectory import Trajectory
from simulation_tools.geometry import Pose


class FoundAgain(NamedTuple):
    """A closed loop: the stamps of a place's first scan and of its later scan."""

    stamp_from_s: float
    stamp_to_s: float


@dataclass(frozen=True)
class SlamRun:
    """SLAM's output for a flight.

    online: the poses estimated during the flight; final: the path estimated at the end; both at the
    processed scans, in `map`. half_way: the map at half of the time. cpu_ms: CPU time of each processed
    scan, (n,); empty if it was not measured. scans: number of received scans.
    """

    online: Trajectory
    final: Trajectory
    grid: OccupancyGrid
    half_way: OccupancyGrid
    closures: Sequence[FoundAgain]
    cpu_ms: np.ndarray
    scans: int


class SlamParticipant:
    """Feeds a SLAM session like its node: scan, attitude and odometry of one instant (a ScanListener).

    half_time_s: time of the map in `SlamRun.half_way`. levelling: correct the UAV's lean; without it a
    leaning scan counts as level.
    """

    def __init__(
        self,
        session: SlamSession,
        lidar: LidarGeometry,
        half_time_s: float = math.inf,
        levelling: bool = True,
    ) -> None:
        self.session = session
        self._lidar = lidar
        self._levelling, self._watch = Levelling(levelling), ScanWatch()
        self._half_time_s = half_time_s
        self._half_way: OccupancyGrid | None = None
        self._online: list[tuple] = []
        self._cpu_ms: list[float] = []
        self._scans = 0

    def on_scan(
        self,
        t_s: float,
        ranges: np.ndarray,
        odometry: Pose,
        truth: Pose,
        covariance: np.ndarray | None = None,
        cloud: Callable[[], LevelCloud | None] = lambda: None,
    ) -> None:
        """Take a scan. As in the node, a scan that no lidar measures, or without a usable beam, is left out.

        covariance: (3, 3) of the odometry's x, y and yaw; None: SLAM's parameters tell it. cloud: returns
        what the lidar saw in space.
        """
        self._scans += 1
        if self._half_way is None and t_s >= self._half_time_s:
            self._half_way = self.session.grid()
        lidar = self._lidar
        started = time.thread_time()  # CPU time of this thread: other work of the machine does not count
        try:
            scan, base_in_odom = self._levelling.level(
                t_s,
                ranges,
                (lidar.angle_min_rad, lidar.angle_increment_rad),
                (lidar.range_min_m, lidar.range_max_m),
                (lidar.position_m, lidar.orientation_xyzw),
                (odometry.position_m, odometry.orientation_xyzw),
            )
            self._watch.check(ranges, scan, base_in_odom)
        except ScanError:
            return
        update = self.session.process(scan, base_in_odom, covariance, cloud)
        if update is not None:
            self._cpu_ms.append(1e3 * (time.thread_time() - started))
            self._online.append((t_s, *update.base_in_map))

    def run(self) -> SlamRun:
        """Return SLAM's output at the end of a flight. Its final path is corrected by all closures."""
        self.session.finish()
        online = np.array(self._online).reshape(-1, 4)
        grid = self.session.grid()
        return SlamRun(
            Trajectory(online[:, 0], online[:, 1:]),
            self.session.trajectory(),
            grid,
            self._half_way or grid,
            tuple(FoundAgain(c.stamp_from_s, c.stamp_to_s) for c in self.session.closures),
            np.array(self._cpu_ms),
            self._scans,
        )


def replay(recording: FlightRecording, session: SlamSession, levelling: bool = True) -> SlamRun:
    """Run SLAM on a recorded flight, as fast as it can."""
    half_time_s = float(recording.times_s[0] + recording.times_s[-1]) / 2
    participant = SlamParticipant(session, recording.lidar, half_time_s, levelling)
    for scan in recording:
        participant.on_scan(*scan)
    return participant.run()


def true_path(times_s: np.ndarray, poses: np.ndarray) -> Trajectory:
    """Return true poses, (n, 7) of position and quaternion xyzw in `world`, as a planar trajectory.

    Without drift `map` coincides with `world`: both begin at the UAV's true pose.
    """
    x, y, z, w = poses[:, 3:].T
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return Trajectory(times_s, np.column_stack((poses[:, :2], yaw)))


def planar(poses: Series) -> Trajectory:
    """Return a log's poses as a planar trajectory."""
    rows = poses.array(*POSE_COLUMNS)
    return true_path(rows[:, 0], rows[:, 1:]) if len(rows) else Trajectory(np.zeros(0), np.zeros((0, 3)))


def true_walls(world_path: Path | str, height_m: float, inside_xy: tuple[float, float]) -> Walls:
    """Return the walls that a perfect map shows at this height around a place.

    Raises:
        SimulationToolsError: the world cannot be read.
        ScenarioError: it has no such walls.
    """
    faces = seen_faces(outlines_of_file(world_path), height_m, inside_xy)
    return Walls(faces.reshape(-1, 4))
