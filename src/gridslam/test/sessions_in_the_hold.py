"""Sessions of SLAM with a log from the hold."""

from __future__ import annotations

import numpy as np
import planar_world

from gridslam import ScanUpdate, SlamParameters, se2
from gridslam.session import SlamSession

PARAMETERS = SlamParameters(
    particles=5, linearUpdate=0.4, angularUpdate=0.3, delta=0.1, srr=0.02, srt=0.02, stt=0.05
)
LIDAR = planar_world.Lidar(6.2, 180, 20.0, 0.01, 10.0)


def way_through_the_hold() -> planar_world.Log:
    """One way through the hold: 8 m along, a corner, 4 m more."""
    route = np.array([(-8.0, -5.0), (0.0, -5.0), (0.0, -1.0)])
    return planar_world.drive(planar_world.hold(), planar_world.along(route, 0.2), LIDAR, seed=4)


def run(
    session: SlamSession, log: planar_world.Log, first: int = 0, last: int | None = None
) -> list[ScanUpdate]:
    """Feed a part of the log; returns the updates."""
    pairs = list(zip(log.scans, log.odometry))[first:last]
    return [update for update in (session.process(scan, odometry) for scan, odometry in pairs) if update]


def base_in_map(session: SlamSession, base_in_odom: np.ndarray) -> np.ndarray:
    """Where the session has the base."""
    return se2.compose(session.map_to_odom, base_in_odom)


def error_m(pose: np.ndarray, truth: np.ndarray) -> float:
    """Distance of two poses, m."""
    return float(np.hypot(*(np.asarray(pose) - truth)[:2]))
