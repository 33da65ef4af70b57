"""The covariances that odometry tells, for the scans of the same stamps."""

from __future__ import annotations

from typing import Callable

import numpy as np
from genpy import Time
from nav_msgs.msg import Odometry

from gridslam.filter.motion_model import is_told
from gridslam_ros.beside.by_stamp import ByStamp

KEPT = 400
PLANE = np.ix_((0, 1, 5), (0, 1, 5))
"""x, y and yaw."""


class OdometryCovariances:
    """The last covariances of x, y and yaw, by stamp.

    Args:
        say: is called with a sentence about odometry that tells none.
    """

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._last: ByStamp[np.ndarray | None] = ByStamp(KEPT)

    def add(self, message: Odometry) -> None:
        """Take an odometry."""
        covariance = np.reshape(message.pose.covariance, (6, 6))[PLANE]
        is_meant = is_told(covariance) and (np.diag(covariance) > 0.0).all()
        if not is_meant:
            self._say("The odometry tells no covariance; the parameters srr, srt, str and stt count instead.")
        self._last.put(message.header.stamp, covariance if is_meant else None)

    def know(self, stamp: Time, tf_ns: int | None) -> bool:
        """Whether the odometry has reached a scan's stamp; see `ByStamp.know`."""
        return self._last.know(stamp, tf_ns)

    def at(self, stamp: Time) -> np.ndarray | None:
        """Return the covariance (3, 3) at a scan's stamp; None: none was told."""
        return self._last.get(stamp)
