"""A small room with a pillar, driven round by a UST: the simulated log of the filter's tests."""

from __future__ import annotations

import numpy as np
from planar_world import Lidar, Log, along, drive, rectangle_route

from gridslam import GridSlam, ScanUpdate, SlamParameters
from gridslam.evaluation import Walls

WALLS = Walls.from_polygons(
    [
        np.array([(-4.0, -3.0), (4.0, -3.0), (4.0, 1.0), (3.0, 1.0), (3.0, 3.0), (-4.0, 3.0)]),
        np.array([(-0.5, -0.4), (0.6, -0.3), (0.5, 0.5), (-0.4, 0.4)]),
    ]
)
UST = Lidar(np.radians(270.0), 136, 10.0, 0.013, 10.0)
PARAMETERS = SlamParameters(particles=8, linearUpdate=0.3, angularUpdate=0.3)


def log(seed: int = 0, laps: float = 1.0) -> Log:
    """The room, once round the pillar."""
    return drive(WALLS, along(rectangle_route(2.0, 1.5, 0.5, laps), 0.1), UST, seed)


def run(slam: GridSlam, log: Log, first: int = 0, last: int | None = None) -> list[ScanUpdate]:
    """Let a filter take in part of a log; return what it said of the scans it processed."""
    pairs = zip(log.scans[first:last], log.odometry[first:last])
    return [update for update in (slam.process(*pair) for pair in pairs) if update is not None]
