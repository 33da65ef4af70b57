"""Scans and clouds of a lidar that moves while it measures them, as points of one instant."""

from __future__ import annotations

from collections import deque
from typing import Callable

import numpy as np
import rospy
from sensor_msgs.msg import LaserScan, PointCloud2

from gridslam import ScanError
from gridslam.volume import Pose, carried, points_of_scan
from gridslam_ros.volume.frames import CloudFrames
from gridslam_ros.volume.messages import readable
from input_checks.point_times import PointTimes
from input_checks_ros.lidar_readings import LidarReadings, times_of
from node_tools import clouds

LONGEST_S = 10.0
"""Of a scan from its first to its last beam."""
KEPT = 8
"""Clouds whose times stay known while they wait for TF."""


class MovingLidar:
    """Undoes the motion from the first beam to the last, which TF tells, as if it was even.

    Args:
        frames: the transforms.
        free_up_to_m: greatest range of the map's rays.
        say: is called with a sentence when something about the readings is odd.
    """

    def __init__(self, frames: CloudFrames, free_up_to_m: float, say: Callable[[str], None]):
        self._frames, self._free_up_to_m, self._say = frames, free_up_to_m, say
        self.readings = LidarReadings(say)
        self._known: deque[tuple[PointCloud2, PointTimes | None]] = deque(maxlen=KEPT)

    def is_complete(self, told: LaserScan | PointCloud2) -> bool:
        """Return whether TF knows the lidar at the first and at the last beam of a message, too.

        Raises:
            ScanError: its beams are not in the order of time, or it cannot be read.
        """
        frame, stamp = told.header.frame_id, told.header.stamp
        since_s = self._swept_s(told)
        return since_s is None or all(
            self._frames.sensor(frame, stamp + rospy.Duration(each_s)) is not None for each_s in since_s
        )

    def points_of(self, told: LaserScan | PointCloud2) -> np.ndarray:
        """Return where the beams ended, float32 (n, 3), in the lidar's frame at the message's stamp.

        Raises:
            ScanError: the message makes no sense, or tells nothing.
        """
        if isinstance(told, PointCloud2):
            return self._points_of_cloud(told)
        scan = self.readings.scan(told)
        since_s = self._swept_s(scan)
        return points_of_scan(
            scan.ranges,
            (scan.angle_min, scan.angle_increment),
            (scan.range_min, scan.range_max),
            self._free_up_to_m,
            None if since_s is None else self._lidar(scan, 0.0).inverse() @ self._lidar(scan, since_s[1]),
        )

    def _points_of_cloud(self, cloud: PointCloud2) -> np.ndarray:
        frame, points = cloud.header.frame_id, readable(clouds.points_of, cloud)
        lidar, times = self._frames.origin_of(frame), self._times_of(cloud)
        if lidar != frame.lstrip("/"):
            in_lidar = self._frames.between(lidar, frame, cloud.header.stamp)
            if in_lidar is None:
                raise ScanError(f'TF does not lead from "{frame}" to "{lidar}".')
            return self.readings.met(cloud.header, in_lidar.of_points(points), self._free_up_to_m)
        points = self.readings.met(cloud.header, points, self._free_up_to_m)
        if times is None:
            return points
        first = self._lidar(cloud, times.first_s)
        shares = (times.since_s - times.first_s) / times.span_s
        in_first = carried(points, shares, first.inverse() @ self._lidar(cloud, times.last_s))
        return (self._lidar(cloud, 0.0).inverse() @ first).of_points(in_first)

    def _lidar(self, told: LaserScan | PointCloud2, since_s: float) -> Pose:
        found = self._frames.sensor(told.header.frame_id, told.header.stamp + rospy.Duration(since_s))
        if found is None:
            raise ScanError("TF does not know where the lidar was during its scan.")
        return found[0]

    def _times_of(self, cloud: PointCloud2) -> PointTimes | None:
        """Return when the points were measured; None: at once, or it does not tell."""
        for other, known in self._known:
            if other is cloud:
                return known
        times = self._read_times(cloud)
        self._known.append((cloud, times))
        return times

    def _read_times(self, cloud: PointCloud2) -> PointTimes | None:
        frame, times = cloud.header.frame_id, readable(times_of, cloud)
        if times is None or self._frames.origin_of(frame) != frame.lstrip("/"):  # they are in a fixed frame
            return None
        if times.why_not:
            self._say(
                f'The points of "{frame}" were measured within {times.span_s:.3g} s, but {times.why_not}: '
                "they count as of one instant. Let the driver stamp clouds and points by one clock."
            )
            return None
        return times

    def _swept_s(self, told: LaserScan | PointCloud2) -> tuple[float, float] | None:
        """Return when the first and the last beam was measured, after the stamp; None: all were at the stamp.

        Raises:
            ScanError: the beams of a scan are not in the order of time.
        """
        if isinstance(told, PointCloud2):
            times = self._times_of(told)
            return None if times is None else (times.first_s, times.last_s)
        if told.time_increment == 0.0:
            return None
        lasts_s = told.time_increment * (len(told.ranges) - 1)
        if not 0.0 < lasts_s <= LONGEST_S:
            raise ScanError(f"A scan lasts {lasts_s:g} s by its time_increment; check the lidar's driver.")
        return 0.0, lasts_s
