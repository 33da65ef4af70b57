"""Finds scans that no lidar measures: one range on all beams, or one scan again and again on the way."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.errors import ScanError
from gridslam.scan import PlanarScan

BEAMS_MIN = 16
"""So many beams of a lidar that measures never have one range: its noise, and the walls, see to that."""
MOVED_M, MOVED_RAD = 0.2, 0.1
"""Odometry that has moved or turned so far since a scan came first has moved for certain."""
LEAP_M, LEAP_RAD = 0.5, 0.5
"""If odometry moves so far from one scan to the next, it may have jumped, and tells nothing here."""
OFF_M, OFF_SHARE = 0.1, 0.03
"""A beam contradicts what was seen before if it ends so much, or this share of its range, nearer."""
CONTRADICTED = 0.1
"""A repeated scan contradicts itself if so many of its beams do. In a long corridor, none does."""


class ScanWatch:
    """Compares each scan with the one before, bit for bit, and with the way since."""

    def __init__(self) -> None:
        self._ranges_m = np.zeros(0)
        self._first: tuple[PlanarScan, np.ndarray] | None = None
        """The first of the equal scans, and the base in odom then."""
        self._last = np.zeros(3)

    def check(self, ranges_m: np.ndarray, scan: PlanarScan, base_in_odom: Sequence[float]) -> None:
        """Take in a scan.

        Args:
            ranges_m: (n,) as the lidar sent them.
            scan: the same, levelled.
            base_in_odom: x, y in m and yaw in rad.

        Raises:
            ScanError: no lidar measures such a scan here.
        """
        sent_m = np.asarray(ranges_m, dtype=np.float64)
        told_m = sent_m[(sent_m > 0.0) & (sent_m <= scan.range_max_m)]
        if len(told_m) >= BEAMS_MIN and np.ptp(told_m) == 0.0:
            raise ScanError(
                f"All {len(told_m)} beams of the scan that have a return tell the same range, "
                f"{told_m[0]:g} m, as no room does: the lidar or its driver does not measure."
            )
        base = np.asarray(base_in_odom, dtype=np.float64)
        if self._first is None or self._is_new(sent_m, base):
            self._ranges_m, self._first = sent_m.copy(), (scan, base)
        self._last = base
        first, began = self._first
        x, y, yaw = se2.between(began, base)
        has_moved = math.hypot(x, y) > MOVED_M or abs(yaw) > MOVED_RAD
        if has_moved and contradicted(first, scan, (x, y, yaw)) > CONTRADICTED:
            raise ScanError(
                "The same scan comes again, equal in every beam, though odometry has moved by "
                f"{math.hypot(x, y):.2f} m and {math.degrees(abs(yaw)):.0f} degrees: the lidar or its driver "
                "repeats it, or odometry has failed."
            )

    def _is_new(self, ranges_m: np.ndarray, base: np.ndarray) -> bool:
        """Return whether the scan differs from the one before, or odometry may have jumped between them."""
        x, y, yaw = se2.between(self._last, base)
        has_leapt = math.hypot(x, y) > LEAP_M or abs(yaw) > LEAP_RAD
        return has_leapt or not np.array_equal(ranges_m, self._ranges_m, equal_nan=True)


def contradicted(first: PlanarScan, scan: PlanarScan, moved: tuple[float, float, float]) -> float:
    """Return the share of a scan's beams that end where another one, from before the motion, saw through."""
    met = np.isfinite(scan.ranges_m)
    along = scan.angles_rad[met]
    ends_m = scan.ranges_m[met, None] * np.column_stack((np.cos(along), np.sin(along)))
    lidar_moved = se2.compose(se2.inverse(first.lidar_in_base), se2.compose(moved, scan.lidar_in_base))
    ends_m = se2.transform(lidar_moved, ends_m)
    order = np.argsort(first.angles_rad)
    angles, ranges_m = first.angles_rad[order], np.minimum(first.ranges_m[order], first.range_max_m)
    right = np.searchsorted(angles, np.arctan2(ends_m[:, 1], ends_m[:, 0]))
    is_between = (right > 0) & (right < len(angles))
    nearer_m = np.minimum(ranges_m[np.maximum(right - 1, 0)], ranges_m[np.minimum(right, len(angles) - 1)])
    far_m = np.hypot(*ends_m.T)
    is_off = is_between & (far_m < nearer_m - np.maximum(OFF_M, OFF_SHARE * far_m))
    return float(is_off.mean()) if len(is_off) else 0.0
