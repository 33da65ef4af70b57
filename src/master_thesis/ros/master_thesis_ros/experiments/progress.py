"""Says how far the work after a flight has come."""

from __future__ import annotations

import rospy


def log_progress(done: int, of: int) -> None:
    """Log how many poses the clearance has been measured at."""
    rospy.loginfo_throttle(5.0, f"Measuring the clearance: {done} of {of}.")
