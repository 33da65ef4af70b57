"""Logs the progress of the work after a flight."""

from __future__ import annotations

import rospy


def log_progress(done: int, of: int) -> None:
    """Log at how many poses the clearance is measured."""
    rospy.loginfo_throttle(5.0, f"Measuring the clearance: {done} of {of}.")
