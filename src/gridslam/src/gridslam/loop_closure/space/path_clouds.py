"""The clouds along a path: one stretch as a map of planes, another one as points to place on it."""

from __future__ import annotations

from typing import NamedTuple, Sequence

import numpy as np

from gridslam import se2
from gridslam.cloud_odometry.parameters import CloudOdometryParameters
from gridslam.cloud_odometry.plane_map import PlaneMap, thinned
from gridslam.level_cloud import LevelCloud
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.measured_path import MeasuredPath

MATCHING = CloudOdometryParameters()
"""How clouds are matched, as by odometry."""
CLOUD_SPACING_M = 0.5
"""m: closer clouds add little."""
QUERY_M = 2.0
"""m: of path on either side of a node whose clouds are placed."""


class Query(NamedTuple):
    """Points (n, 3) m in the level frame at a node, and the lidar's place (3,) there."""

    points_m: np.ndarray
    lidar_m: np.ndarray


class PathClouds:
    """Keeps the clouds of a path."""

    def __init__(self, parameters: LoopClosureParameters) -> None:
        self._stretch_m = parameters.stretch_m
        self._clouds: Sequence[LevelCloud | None] = ()

    def extend(self, clouds: Sequence[LevelCloud | None]) -> None:
        """Take in the clouds at all nodes of a path; None: there was none."""
        self._clouds = clouds

    def known(self, path: MeasuredPath) -> np.ndarray:
        """Return at which nodes (k,) cloud and height are known."""
        return np.array([cloud is not None for cloud in self._clouds], bool) & np.isfinite(path.heights_m)

    def around(self, path: MeasuredPath, node: int) -> PlaneMap:
        """Return the planes that were seen within `stretch_m` of path, in the level frame at a node."""
        planes = PlaneMap(MATCHING)
        for points, lidar_m in self._placed(path, node, self._stretch_m):
            planes.add(points, lidar_m)
        return planes

    def query(self, path: MeasuredPath, node: int) -> Query:
        """Return what was seen within `QUERY_M` of path, in the level frame at a node which has a cloud."""
        placed = [points for points, _ in self._placed(path, node, QUERY_M)]
        cloud = self._clouds[node]
        assert cloud is not None  # see `known`
        return Query(thinned(np.concatenate(placed), MATCHING.thinned_m), cloud.lidar_m)

    def _placed(self, path: MeasuredPath, node: int, within_m: float) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return points and lidar of the clouds of a stretch, in the level frame at its middle."""
        way_m, placed, last_m = path.way_in_space_m, [], -np.inf
        is_near = self.known(path) & (np.abs(way_m - way_m[node]) <= within_m)
        for other in np.flatnonzero(is_near).tolist():
            cloud = self._clouds[other]
            if cloud is None or (way_m[other] - last_m < CLOUD_SPACING_M and other != node):
                continue
            last_m = way_m[other]
            x, y, yaw = se2.between(path.poses[node], path.poses[other]).tolist()
            turn = about_z(yaw).T
            place = np.array((x, y, path.heights_m[other] - path.heights_m[node]))
            placed.append((cloud.points_m @ turn + place, cloud.lidar_m @ turn + place))
        return placed


def about_z(yaw_rad: float) -> np.ndarray:
    """Return the rotation (3, 3) about the vertical."""
    cos, sin = np.cos(yaw_rad), np.sin(yaw_rad)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
