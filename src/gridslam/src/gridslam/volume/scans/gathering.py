"""Gathers the scans of a planar lidar into clouds, because one scan of them holds a slice only."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gridslam.volume.clouds import Pose

LONGEST_S = 1.0
"""Of a cloud, from its first scan to its last."""
SHIFT_VOXELS = 0.75
"""The lidar moves by less within a cloud, because all rays of a cloud begin at one place."""


class PlacedCloud(NamedTuple):
    """Points (n, 3) of the sensor's frame, and the poses at the stamp."""

    stamp_s: float
    points: np.ndarray
    sensor_in_odom: Pose
    odom_in_map: Pose


class ScanGathering:
    """Scans that were taken at one place, within a short time, become one cloud.

    Args:
        resolution_m: side of the map's voxels.
    """

    def __init__(self, resolution_m: float):
        self._shift_m = SHIFT_VOXELS * resolution_m
        self._scans: list[PlacedCloud] = []

    def add(self, scan: PlacedCloud) -> PlacedCloud | None:
        """Take in a scan; return the cloud of the ones before, if this one is no part of it."""
        if not self._scans or self._belongs(scan):
            self._scans.append(scan)
            return None
        cloud = self.take()
        self._scans.append(scan)
        return cloud

    def _belongs(self, scan: PlacedCloud) -> bool:
        first = self._scans[0]
        way_m = np.linalg.norm(scan.sensor_in_odom.translation - first.sensor_in_odom.translation)
        return bool(0.0 <= scan.stamp_s - first.stamp_s < LONGEST_S and way_m < self._shift_m)

    def take(self) -> PlacedCloud | None:
        """Return the cloud of the scans so far, with the first one's poses, and forget them; None: none."""
        scans, self._scans = self._scans, []
        if not scans:
            return None
        to_first = scans[0].sensor_in_odom.inverse()
        parts = [(to_first @ scan.sensor_in_odom).of_points(scan.points) for scan in scans[1:]]
        return scans[0]._replace(points=np.concatenate([scans[0].points, *parts]))
