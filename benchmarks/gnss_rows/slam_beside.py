"""SLAM beside a flight without GNSS: how far off are the poses that it corrects."""

from __future__ import annotations

import functools
import math

import numpy as np

from flights.flight.closed_loop import ClosedLoop
from flights.flight.flight_recording import LidarGeometry
from flights.mapping.slam_run import SlamParticipant
from flights.mapping.slam_setup import read_setup
from gridslam import se2
from simulation_tools.geometry import Pose


class SlamBeside:
    """Follows the scans of a closed loop as `slam_gridslam` does, with loop closure (a ScanListener).

    The flight does not use it. off_m, high_m: error of the pose in the map at each scan, level and of its
    height, m.
    """

    def __init__(self, loop: ClosedLoop, seed: int) -> None:
        assert loop.own_odometry is not None  # there is no GNSS
        self._session = read_setup("hold").session(
            seed, loop_closure=True, odometry_in_space=loop.own_odometry.uses_clouds
        )
        self._participant, self._loop = SlamParticipant(self._session, LidarGeometry.of(loop.lidar)), loop
        self.off_m: list[float] = []
        self.high_m: list[float] = []

    def on_scan(self, t_s: float, ranges: np.ndarray, odometry: Pose, truth: Pose) -> None:
        """Take a scan, the odometry and the truth of one instant."""
        own = self._loop.own_odometry
        assert own is not None  # there is no GNSS
        estimates = reversed(own.estimates)
        told = next(each for each in estimates if abs(each.stamp_s - t_s) < 1e-6).planar_covariance
        cloud = functools.partial(own.level_cloud, t_s, odometry)
        self._participant.on_scan(t_s, ranges, odometry, truth, told, cloud)
        if self._session.map_to_odom is None:
            return
        in_odom = np.array((*odometry.position_m[:2], odometry.yaw_rad))
        x, y, _ = se2.compose(np.array(self._session.map_to_odom), in_odom).tolist()
        self.off_m.append(math.dist((x, y), truth.position_m[:2]))
        self.high_m.append(odometry.position_m[2] + self._session.rise_m - truth.position_m[2])

    def figures(self) -> dict[str, float]:
        """Return the root mean square and the greatest of the errors, 95 % of heights, m; closures."""
        off_m, high_m = np.array(self.off_m), np.abs(self.high_m)
        return {
            "slam_ate_m": float(np.sqrt(np.square(off_m).mean())),
            "slam_worst_m": float(off_m.max()),
            "slam_height_p95_m": float(np.percentile(high_m, 95)),
            "closures": len(self._session.closures),
        }
