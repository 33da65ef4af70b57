"""Decides when `inspect` acknowledges a scan. In lockstep the simulator waits for that."""

from __future__ import annotations

import math
import time

import rospy
from std_msgs.msg import Header

from node_tools.lockstep.working import Working

MAP_LATE_S = 1.6
"""A scan is acknowledged when the map is at most so much older."""
STARVED_S = 3.0
"""Wall time after which nobody waits for a map that does not come."""


class SurveyBarrier:
    """The newest scan that is not acknowledged. Publishes ~processed, and ~working while there is one.

    Attributes:
        map_s: stamp of the newest map.
    """

    def __init__(self) -> None:
        self.map_s = -math.inf
        self._scan: Header | None = None
        self._wall_s = 0.0
        self._processed = rospy.Publisher("~processed", Header, queue_size=1, tcp_nodelay=True)
        self._working = Working(lambda: self._scan is not None)

    def take(self, scan: Header) -> None:
        """Take a scan."""
        self._scan, self._wall_s = scan, time.monotonic()

    def is_ready(self, pose_s: float) -> bool:
        """Return whether pose and map are as new as the scan. pose_s: stamp of the newest pose, or -inf."""
        if self._scan is None:
            return False
        stamp_s = self._scan.stamp.to_sec()
        if pose_s < stamp_s - 1e-6:
            return False
        return stamp_s - self.map_s <= MAP_LATE_S or time.monotonic() - self._wall_s >= STARVED_S

    def acknowledge(self) -> None:
        """Acknowledge the scan, if there is one."""
        if self._scan is not None:
            self._processed.publish(self._scan)
            self._scan = None
