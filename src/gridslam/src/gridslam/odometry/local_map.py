"""The local map: the surfaces that the last keyframes saw."""

from __future__ import annotations

from collections import deque

import numpy as np

from gridslam import se2
from gridslam.kernels.nearest import NearestPoints
from gridslam.kernels.surfaces import surface_normals, thin_out
from gridslam.kernels.surfels import SurfelTable, add_points, find_surfels, move_cells
from gridslam.odometry.parameters import LidarOdometryParameters
from gridslam.scan import PlanarScan

SLOTS = 1 << 14
"""Of the table of surface elements at first. It grows before it is half full."""
SPACING, DEPTH = 0.8, 1.0
"""Cells: beams that end within this, along and across the bearing, are averaged."""


def beams_of(scan: PlanarScan, parameters: LidarOdometryParameters) -> np.ndarray:
    """Return (m, 7) a scan's ends nearer than ``range_m`` in m, as `find_surfels` takes them.

    The normals point towards the lidar.
    """
    reach_m = min(parameters.range_m, scan.range_max_m - parameters.cell_m)
    near = (scan.ranges_m < reach_m) & (scan.ranges_m > 0.0)
    bearings, ranges = scan.angles_rad[near], scan.ranges_m[near] / parameters.cell_m
    if bearings.size and (np.diff(bearings) < 0.0).any():
        order = np.argsort(bearings, kind="stable")
        bearings, ranges = bearings[order], ranges[order]
    thin_bearings, thin_ranges = np.empty_like(bearings), np.empty_like(ranges)
    count = thin_out(bearings, ranges, SPACING, DEPTH, thin_bearings, thin_ranges)
    bearings, ranges = thin_bearings[:count], thin_ranges[:count]
    points = np.stack((ranges * np.cos(bearings), ranges * np.sin(bearings)), axis=1)
    normals, flat = np.empty_like(points), np.empty(count, np.bool_)
    surface_normals(points, np.empty(count, np.bool_), normals, flat, False)
    normals *= np.where(flat, -np.sign((normals * points).sum(axis=1)), 0.0)[:, None]
    beams = np.zeros((count, 7))
    beams[:, 0:2] = se2.transform(scan.lidar_in_base, points * parameters.cell_m)
    beams[:, 2:4] = se2.transform((0.0, 0.0, scan.lidar_in_base[2]), normals)
    return beams


class LocalMap:
    """Surface elements of the last keyframes, in the odometry's frame."""

    def __init__(self, parameters: LidarOdometryParameters) -> None:
        self._p = parameters
        self._table, self._taken = SurfelTable.empty(SLOTS), 0
        self._keyframes: deque[np.ndarray] = deque()
        self._poses: deque[np.ndarray] = deque()

    @property
    def is_empty(self) -> bool:
        """Whether there is no keyframe yet."""
        return not self._keyframes

    @property
    def newest_pose(self) -> np.ndarray:
        """(3,) x, y, yaw of the last keyframe."""
        return self._poses[-1]

    def __len__(self) -> int:
        return len(self._keyframes)

    def add(self, pose: np.ndarray, beams: np.ndarray) -> None:
        """Add a scan's beams (m, 7) at a pose (3,); the oldest keyframe leaves when there are too many."""
        points = np.ones((len(beams), 5))
        points[:, 0:2] = se2.transform(pose, beams[:, 0:2])
        points[:, 2:4] = se2.transform((0.0, 0.0, pose[2]), beams[:, 2:4])
        self._make_room(len(points))
        self._taken += add_points(points, 1.0, self._p.cell_m, self._table)
        self._keyframes.append(points)
        self._poses.append(pose.copy())
        if len(self._keyframes) > self._p.keyframes:
            add_points(self._keyframes.popleft(), -1.0, self._p.cell_m, self._table)
            self._poses.popleft()

    def _make_room(self, count: int) -> None:
        """Let at most half of the slots be taken when so many points have come."""
        if 2 * (self._taken + count) <= len(self._table.cells):
            return
        live = int(np.count_nonzero(self._table.sums[:, 4]))
        slots = max(SLOTS, 1 << (4 * (live + count) - 1).bit_length())
        table, self._table = self._table, SurfelTable.empty(slots)
        self._taken = move_cells(table, self._table)

    def find(
        self, pose: np.ndarray, beams: np.ndarray, reach_m: float, nearby: NearestPoints
    ) -> tuple[int, float]:
        """Find the surface nearest to each beam's end; see `find_surfels`.

        Return their number, and the mean of 1 / (number of keyframes' points) in their cells.
        """
        x, y, yaw = pose
        found, newness = find_surfels(x, y, yaw, beams, reach_m, self._p.cell_m, self._table, nearby)
        return found, newness / found if found else 1.0
