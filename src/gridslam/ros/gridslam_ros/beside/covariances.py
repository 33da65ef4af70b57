"""The covariances that odometry tells, for the scans of the same stamps."""

from __future__ import annotations

from typing import Callable

import numpy as np
from genpy import Time
from nav_msgs.msg import Odometry

from gridslam.filter.motion_model import is_told

KEPT = 400
LATE_NS = 1_000_000_000
"""A scan waits for its covariance until TF is newer by this much."""
PLANE = np.ix_((0, 1, 5), (0, 1, 5))
"""x, y and yaw."""


class OdometryCovariances:
    """The last covariances of x, y and yaw, by stamp.

    Args:
        say: is called with a sentence about odometry that tells none.
    """

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._known: dict[int, np.ndarray | None] = {}
        self._newest_ns = -1

    def add(self, message: Odometry) -> None:
        """Take an odometry."""
        stamp_ns = message.header.stamp.to_nsec()
        if stamp_ns < self._newest_ns:  # the clock went back
            self._known.clear()
        self._newest_ns = stamp_ns
        covariance = np.reshape(message.pose.covariance, (6, 6))[PLANE]
        is_meant = is_told(covariance) and (np.diag(covariance) > 0.0).all()
        if not is_meant:
            self._say("The odometry tells no covariance; the parameters srr, srt, str and stt count instead.")
        self._known[stamp_ns] = covariance if is_meant else None
        while len(self._known) > KEPT:
            del self._known[next(iter(self._known))]

    def know(self, stamp: Time, tf_ns: int | None) -> bool:
        """Whether the odometry has reached a scan's stamp, or TF is so much newer that it will not come."""
        is_late = tf_ns is not None and tf_ns - stamp.to_nsec() > LATE_NS
        return is_late or self._newest_ns >= stamp.to_nsec()

    def at(self, stamp: Time) -> np.ndarray | None:
        """Return the covariance (3, 3) at a scan's stamp; None: none was told."""
        return self._known.get(stamp.to_nsec())
