"""Notices that scans change while odometry stands still, as when it has failed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gridslam import se2
from gridslam.scan import PlanarScan

STILL_M, STILL_RAD = 0.02, 0.01
"""Odometry that moves by less than this stands still."""
LOOK_EVERY_S = 1.0
CHANGED_M, CHANGED_SHARE = 0.2, 0.1
"""A beam has changed if its range differs by more than the first, and by more than this share of it."""
CHANGED_BEAMS = 0.45
"""A scan has changed if this share of its beams has. People before the lidar rarely cover so many."""


@dataclass(frozen=True, eq=False)
class StandstillState:
    """A `Standstill` to save.

    Raises:
        ValueError: it makes no sense.
    """

    scan: PlanarScan | None
    base_in_odom: np.ndarray | None
    """(3,) at the scan."""
    looked_s: float

    def __post_init__(self) -> None:
        is_sane = (self.scan is None) == (self.base_in_odom is None) and np.isfinite(self.looked_s)
        if not is_sane or (self.base_in_odom is not None and self.base_in_odom.shape != (3,)):
            raise ValueError("the standstill's state makes no sense")


class Standstill:
    """Compares scans while odometry stands still."""

    def __init__(self) -> None:
        self._first: tuple[PlanarScan, np.ndarray] | None = None
        self._looked_s = 0.0

    def has_changed(self, scan: PlanarScan, base_in_odom: np.ndarray) -> bool:
        """Return whether the scan differs from that at the beginning of the standstill.

        It is compared once in LOOK_EVERY_S. After a change the comparison begins anew.
        """
        if self._first is None or not self._stands(scan, base_in_odom):
            self._first, self._looked_s = (scan, base_in_odom), scan.stamp_s
            return False
        if 0.0 <= scan.stamp_s - self._looked_s < LOOK_EVERY_S:
            return False
        self._looked_s = scan.stamp_s
        if changed_share(self._first[0], scan) < CHANGED_BEAMS:
            return False
        self._first = scan, base_in_odom
        return True

    def state(self) -> StandstillState:
        """Return the first scan of the standstill, and when a scan was compared last."""
        scan, base = (None, None) if self._first is None else self._first
        return StandstillState(scan, base, self._looked_s)

    def restore(self, state: StandstillState) -> None:
        """Go on from a state."""
        if state.scan is not None and state.base_in_odom is not None:
            self._first = state.scan, state.base_in_odom
        self._looked_s = float(state.looked_s)

    def _stands(self, scan: PlanarScan, base_in_odom: np.ndarray) -> bool:
        assert self._first is not None
        first, where = self._first
        x, y, yaw = se2.between(where, base_in_odom)
        same_lidar = first.lidar_in_base == scan.lidar_in_base and len(first.ranges_m) == len(scan.ranges_m)
        return same_lidar and np.hypot(x, y) < STILL_M and abs(yaw) < STILL_RAD


def changed_share(before: PlanarScan, now: PlanarScan) -> float:
    """Return the share of beams, with a return in both scans, whose ranges differ.

    Both scans must be of one lidar. Beams without a return in either say nothing.
    """
    far = now.range_max_m - 0.01
    both = (before.ranges_m < far) & (now.ranges_m < far)
    if not both.any():
        return 0.0
    ranges = before.ranges_m[both]
    differences = np.abs(now.ranges_m[both] - ranges)
    return float((differences > np.maximum(CHANGED_M, CHANGED_SHARE * ranges)).mean())
