"""Finds two lidars whose scans come in turns under one frame. TF tells the place of one of them only."""

from __future__ import annotations

from collections import deque
from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.errors import MountingError
from gridslam.inputs.scan_watch import contradicted
from gridslam.scan import PlanarScan

OTHER_SHARE, SAME_SHARE = 0.25, 0.1
"""A scan is of another lidar than the scan before, if more of its beams than the first end where that one saw
through, and by the second more than where the scan before that one did."""
TURNS = 8
"""So many of them decide. Each scan that tells otherwise takes one away."""
SAME_MIN = 30
"""After so many scans that agree with the scan before, the watch ends. So it costs nothing later."""


class TurnsWatch:
    """Compares each scan with the two before it, where odometry puts them."""

    def __init__(self) -> None:
        self._last: deque[tuple[PlanarScan, np.ndarray]] = deque(maxlen=2)
        self._turns = self._same = 0

    def check(self, scan: PlanarScan, base_in_odom: Sequence[float]) -> None:
        """Take in a levelled scan with the base in odom, x, y in m and yaw in rad.

        Raises:
            MountingError: two lidars send scans as if they were one.
        """
        if self._turns >= TURNS:
            raise MountingError(
                "Every second scan contradicts the one before it, and agrees with the one before that: two "
                "lidars send scans in one frame. Give each its own frame_id and topic; SLAM gets one of them."
            )
        if self._same >= SAME_MIN:
            return
        base = np.asarray(base_in_odom, dtype=np.float64)
        if len(self._last) == 2:
            older, newer = (self._contradicted(each, scan, base) for each in self._last)
            is_turn = newer > max(OTHER_SHARE, older + SAME_SHARE)
            self._turns = max(0, self._turns + (1 if is_turn else -1))
            self._same += newer < SAME_SHARE
        self._last.append((scan, base))

    def _contradicted(
        self, earlier: tuple[PlanarScan, np.ndarray], scan: PlanarScan, base: np.ndarray
    ) -> float:
        x, y, yaw = se2.between(earlier[1], base).tolist()
        return contradicted(earlier[0], scan, (x, y, yaw))
