"""Scans of a planar lidar that moves while it scans, as clouds."""

from __future__ import annotations

import numpy as np
import rospy
from sensor_msgs.msg import LaserScan, PointCloud2

from gridslam import ScanError
from gridslam.volume import Pose, points_of_scan
from gridslam_ros.volume.frames import CloudFrames

LONGEST_S = 10.0
"""Of a scan from its first to its last beam."""


class MovingScans:
    """Undoes the motion from a scan's first beam to its last, which TF tells.

    Args:
        frames: the transforms.
        free_up_to_m: greatest range of the map's rays.
    """

    def __init__(self, frames: CloudFrames, free_up_to_m: float):
        self._frames, self._free_up_to_m = frames, free_up_to_m

    def is_complete(self, scan: LaserScan | PointCloud2) -> bool:
        """Return whether TF knows the lidar at the last beam, too. Of a cloud only the stamp counts."""
        end = _end(scan)
        return end is None or self._frames.sensor(scan.header.frame_id, end) is not None

    def points_of(self, scan: LaserScan) -> np.ndarray:
        """Return the ends of the beams, float32 (n, 3), in the lidar's frame at the scan's stamp.

        Raises:
            ScanError: the scan makes no sense, or tells nothing.
        """
        return points_of_scan(
            scan.ranges,
            (scan.angle_min, scan.angle_increment),
            (scan.range_min, scan.range_max),
            self._free_up_to_m,
            self._last_in_first(scan),
        )

    def _last_in_first(self, scan: LaserScan) -> Pose | None:
        end = _end(scan)
        if end is None:
            return None
        frame = scan.header.frame_id
        first, last = self._frames.sensor(frame, scan.header.stamp), self._frames.sensor(frame, end)
        if first is None or last is None:
            raise ScanError("TF does not know where the lidar was during its scan.")
        return first[0].inverse() @ last[0]


def _end(scan: LaserScan | PointCloud2) -> rospy.Time | None:
    """Return when a scan's last beam was measured; None: all beams are of its stamp.

    Raises:
        ScanError: its beams are not in the order of time.
    """
    step_s = getattr(scan, "time_increment", 0.0)
    if step_s == 0.0:
        return None
    lasts_s = step_s * (len(scan.ranges) - 1)
    if not 0.0 < lasts_s <= LONGEST_S:
        raise ScanError(f"A scan lasts {lasts_s:g} s by its time_increment; check the lidar's driver.")
    return scan.header.stamp + rospy.Duration(lasts_s)
