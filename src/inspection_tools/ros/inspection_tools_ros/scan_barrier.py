"""Decides when a mission acknowledges a scan. In lockstep the simulator waits for that."""

from __future__ import annotations

import rospy
from nav_msgs.msg import Odometry
from std_msgs.msg import Header


class ScanBarrier:
    """The messages of the newest scan's instant.

    Attributes:
        scan: header of the newest scan. pose: the newest pose. answered: stamp of the pose that the position
            controller answered last.
    """

    def __init__(self) -> None:
        self.scan: Header | None = None
        self.pose: Odometry | None = None
        self.answered: rospy.Time | None = None
        self._unheard: Header | None = None  # of a scan whose new setpoint has not arrived yet

    def complete(self) -> bool:
        """Return whether scan, pose and the position controller's answer to the pose are of one instant."""
        if self.scan is None or self.pose is None or self._unheard is not None:
            return False
        return self.scan.stamp == self.pose.header.stamp == self.answered

    def decided(self, new_setpoint: bool) -> Header | None:
        """Return the scan to acknowledge at once, if there is no new setpoint."""
        header, self.answered = self.scan, None
        if not new_setpoint:
            return header
        self._unheard = header
        return None

    def heard(self) -> Header | None:
        """Return the scan that waited for the setpoint, which has arrived."""
        header, self._unheard = self._unheard, None
        return header
