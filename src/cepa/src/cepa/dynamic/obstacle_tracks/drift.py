"""How much the odometry may have drifted lately: more than that is no drift, but things that move alike."""

from __future__ import annotations

import numpy as np

from cepa.dynamic.constants.obstacle_tracks import (
    DRIFT_RATE_M_S,
    DRIFT_RATE_RAD_S,
    DRIFT_SLACK_M,
    DRIFT_SLACK_RAD,
)
from cepa.motion import DOUBTED, Doubt

SLACK = np.array([DRIFT_SLACK_M, DRIFT_SLACK_M, DRIFT_SLACK_RAD])
RATE = np.array([DRIFT_RATE_M_S, DRIFT_RATE_M_S, DRIFT_RATE_RAD_S])


class RecentDrift:
    """The corrections of the last scans (3: x, y in m, turn in rad), less what any odometry drifts.

    From scan to scan an odometry is noisy, and by and by it drifts. Neither takes it away at a walking pace.
    People abreast, who come at a walking pace in an open field, would.
    """

    def __init__(self) -> None:
        self._sum = np.zeros(3)

    def limits_after(self, time_s: float, doubt: Doubt = DOUBTED) -> np.ndarray:
        """Return the least and the greatest correction (2, 3) of a scan so long after the last one.

        What an IMU confirms is not corrected at all.
        """
        self._sum -= np.clip(self._sum, -RATE * time_s, RATE * time_s)
        limits = np.stack((-SLACK - self._sum, SLACK - self._sum))
        if not doubt.turn:
            limits[:, 2] = 0.0
        if not doubt.shift:
            limits[:, :2] = 0.0
        return limits

    def take_in(self, correction: np.ndarray) -> None:
        """Take in the correction (3,) of the scan."""
        self._sum += correction
